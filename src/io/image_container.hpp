#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "srslam/core/array_view.hpp"

namespace srslam::io_detail {

enum class ImageFormat : std::uint8_t { kPng, kJpeg };

/// What an image file says of itself.
struct ImageHeader {
  ImageFormat format = ImageFormat::kPng;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  int bits_per_channel = 0;
  int num_channels = 0;  ///< a palette counts as one channel
  bool has_palette = false;
};

/// Walks through the container of a PNG or JPEG file without decoding pixels, so that decoders
/// are only given files that are whole: PNG chunks with their checksums up to IEND, JPEG segments
/// up to the end-of-image marker. Returns why the file is damaged or not supported, or an empty
/// string and the header. Linear time, no allocation on success.
std::string inspect_image(ArrayView<const unsigned char> bytes, ImageHeader* header);

/// CRC-32 of PNG (ISO 3309).
std::uint32_t crc32(ArrayView<const unsigned char> bytes);

}  // namespace srslam::io_detail
