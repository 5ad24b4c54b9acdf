#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "srslam/core/image_view.hpp"
#include "srslam/core/status.hpp"
#include "srslam/io/camera_file.hpp"

namespace srslam {

/// Which form of the colour image load() decodes. Grey alone is the cheapest: it comes straight
/// from the decoder, and has the same bits in both modes.
enum class ColorMode : std::uint8_t { kGray, kGrayAndColor };

struct TumDatasetOptions {
  double max_time_difference_s = 0.02;  ///< colour to depth, inclusive; > 0
  /// File of `t_color color_file t_depth depth_file` lines to use instead of `rgb.txt`, `depth.txt`
  /// and the association made here. Its pairs are taken as they are, whatever their time
  /// difference; the image paths in it are relative to the dataset folder. Empty: none.
  std::string association_file;
  ColorMode color_mode = ColorMode::kGray;
};

/// One colour frame and the depth image that goes with it.
struct TumFrameEntry {
  double timestamp_s = 0.0;        ///< of the colour image
  double depth_timestamp_s = 0.0;  ///< meaningless without depth
  std::string color_file;          ///< relative to the dataset folder
  std::string depth_file;          ///< empty: no depth within the tolerance
  bool has_depth() const { return !depth_file.empty(); }
};

/// How colour and depth lists were paired. Each colour frame takes its nearest depth image, so
/// one depth image may serve two colour frames; of two equally near the earlier is taken.
struct AssociationReport {
  std::size_t num_color = 0;           ///< colour frames listed
  std::size_t num_depth = 0;           ///< depth images listed
  std::size_t num_with_depth = 0;      ///< colour frames with depth within the tolerance
  std::size_t num_shared_depth = 0;    ///< colour frames whose depth image also serves another
  double max_time_difference_s = 0.0;  ///< largest accepted difference
};

/// Working memory of TumDataset::load(); its content means nothing to a caller.
struct LoadScratch {
  std::vector<std::uint8_t> file_bytes;
  std::vector<std::uint16_t> raw_depth;
};

/// A decoded frame. Buffers are reused when the same object is loaded into again.
struct LoadedFrame {
  FileStatus status;  ///< why a damaged frame could not be loaded
  std::size_t index = 0;
  double timestamp_s = 0.0;
  bool has_depth = false;  ///< false also when the frame could not be loaded
  ImageBuffer<std::uint8_t> gray;
  ImageBuffer<Bgr8> color;     ///< empty unless ColorMode::kGrayAndColor
  ImageBuffer<float> depth_m;  ///< 0 where the sensor saw nothing; empty when !has_depth
  double load_ms = 0.0;        ///< wall time that load() took
  LoadScratch scratch;
};

/// A folder in the TUM RGB-D layout: `rgb.txt`, `depth.txt`, optional `groundtruth.txt`,
/// `detections.txt` and `camera.yaml`. Opening reads the lists only; images are decoded by load().
class TumDataset {
 public:
  /// Reads and associates the lists. Missing or empty lists, malformed lines, repeated or
  /// decreasing time stamps, and image paths that are absolute, climb with `..`, or hold white
  /// space or backslashes fail with file, line and reason; `dataset` is then left empty. (Only the
  /// text of a path is checked; links in the folder are followed.)
  static FileStatus open(const std::string& folder, const TumDatasetOptions& options,
                         TumDataset* dataset);

  const std::string& folder() const { return folder_; }
  const TumDatasetOptions& options() const { return options_; }
  std::size_t size() const { return entries_.size(); }
  const TumFrameEntry& entry(std::size_t index) const { return entries_[index]; }
  const AssociationReport& association() const { return association_; }

  /// Paths of the optional companions, empty when the file does not exist.
  const std::string& groundtruth_file() const { return groundtruth_file_; }
  const std::string& detections_file() const { return detections_file_; }
  const std::string& camera_file() const { return camera_file_; }

  /// Decodes frame `index`. `camera` states the image size and the depth scale: an image of
  /// another size, a depth image that is not a 16-bit single-channel PNG, a colour image that is
  /// not an 8-bit PNG or JPEG, or a missing, empty, truncated or otherwise damaged file fail with
  /// the file's name and the reason, and leave the images of `frame` empty. Sizes are read from the
  /// header before anything is decoded, and orientation tags are ignored: the pixels are the
  /// sensor's. Depth is raw / depth_units_per_m rounded to float. The status is also
  /// stored in `frame`. Re-entrant.
  ///
  /// A PNG's checksums prove it whole; a JPEG has none, so flipped bits in one may show as a
  /// garbled picture and make libjpeg print a warning.
  FileStatus load(std::size_t index, const RgbdCamera& camera, LoadedFrame* frame) const;

 private:
  std::string folder_;
  TumDatasetOptions options_;
  std::vector<TumFrameEntry> entries_;
  AssociationReport association_;
  std::string groundtruth_file_;
  std::string detections_file_;
  std::string camera_file_;
};

/// Hands out frames [first, last) of a dataset in order while one background thread decodes
/// at most `read_ahead` frames in advance; buffers are recycled, so that after the first
/// read_ahead + 1 frames no image is allocated. The dataset must outlive it. One caller at a time;
/// destroying it early waits for the frame under way at most.
class FrameReader {
 public:
  /// read_ahead = 0 decodes in the caller's thread, as happens when no thread can be started.
  /// `last_index` is cut to the dataset's size; an empty range hands out nothing.
  FrameReader(const TumDataset& dataset, const RgbdCamera& camera, std::size_t first_index,
              std::size_t last_index, std::size_t read_ahead = 4);
  ~FrameReader();
  FrameReader(const FrameReader&) = delete;
  FrameReader& operator=(const FrameReader&) = delete;

  /// Swaps the next frame into `frame`; false at the end. A damaged frame is handed out too, with
  /// its status saying why, so that the caller can count and skip it.
  bool next(LoadedFrame* frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srslam
