#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "srslam/io/camera_file.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using test::expect_failure;
using test::TempFolder;
using test::write_text;

void expect_same(const RgbdCamera& a, const RgbdCamera& b) {
  EXPECT_EQ(a.camera.width_px, b.camera.width_px);
  EXPECT_EQ(a.camera.height_px, b.camera.height_px);
  EXPECT_EQ(a.camera.fx_px, b.camera.fx_px);
  EXPECT_EQ(a.camera.fy_px, b.camera.fy_px);
  EXPECT_EQ(a.camera.cx_px, b.camera.cx_px);
  EXPECT_EQ(a.camera.cy_px, b.camera.cy_px);
  EXPECT_EQ(a.camera.k1, b.camera.k1);
  EXPECT_EQ(a.camera.k2, b.camera.k2);
  EXPECT_EQ(a.camera.p1, b.camera.p1);
  EXPECT_EQ(a.camera.p2, b.camera.p2);
  EXPECT_EQ(a.camera.k3, b.camera.k3);
  EXPECT_EQ(a.depth_units_per_m, b.depth_units_per_m);
  EXPECT_EQ(a.fps, b.fps);
  EXPECT_EQ(a.groundtruth_frame, b.groundtruth_frame);
}

TEST(CameraPreset, HoldsThePublishedCalibrations) {
  EXPECT_EQ(camera_preset_names(),
            (std::vector<std::string>{"tum_fr1", "tum_fr2", "tum_fr3", "bonn"}));
  const std::vector<std::vector<double>> published = {
      {517.306408, 516.469215, 318.643040, 255.313989, 0.262383, -0.953104, -0.005358, 0.002628,
       1.163314},
      {520.908620, 521.007327, 325.141442, 249.701764, 0.231222, -0.784899, -0.003257, -0.000105,
       0.917205},
      {535.4, 539.2, 320.1, 247.6, 0.0, 0.0, 0.0, 0.0, 0.0},
      {542.822841, 542.576870, 315.593520, 237.756098, 0.039903, -0.099343, -0.000730, -0.000144,
       0.0}};
  const std::vector<std::string> names = camera_preset_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    SCOPED_TRACE(names[i]);
    RgbdCamera preset;
    const FileStatus status = camera_preset(names[i], &preset);
    ASSERT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(preset.name, names[i]);
    EXPECT_TRUE(preset.validate().ok());
    const PinholeCamera& camera = preset.camera;
    EXPECT_EQ((std::vector<double>{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px,
                                   camera.k1, camera.k2, camera.p1, camera.p2, camera.k3}),
              published[i]);
    EXPECT_EQ(camera.width_px, 640);
    EXPECT_EQ(camera.height_px, 480);
    EXPECT_EQ(preset.depth_units_per_m, 5000.0);
    EXPECT_EQ(preset.fps, 30.0);
    EXPECT_EQ(preset.groundtruth_frame,
              names[i] == "bonn" ? GroundtruthFrame::kBonnMarker : GroundtruthFrame::kCamera);
  }
}

TEST(CameraPreset, UnknownNameListsTheKnownOnes) {
  RgbdCamera camera = test::tiny_camera();
  expect_failure(camera_preset("tum_fr4", &camera), StatusCode::kNotFound, "", 0,
                 "unknown camera preset 'tum_fr4'; known presets: tum_fr1, tum_fr2, tum_fr3, bonn");
  expect_same(camera, test::tiny_camera());
}

class CameraFile : public testing::Test {
 protected:
  FileStatus read(const std::string& text) {
    write_text(path_, text);
    return read_camera_file(path_, &camera_);
  }

  TempFolder folder_;
  std::string path_ = folder_ / "camera.yaml";
  RgbdCamera camera_ = test::tiny_camera();
  const std::string minimal_ =
      "width_px: 640\nheight_px: 480\nfx_px: 600.5\nfy_px: 601\ncx_px: 320\ncy_px: 240\n"
      "depth_units_per_m: 1000\n";
};

TEST_F(CameraFile, MinimalFileGetsTheDocumentedDefaults) {
  for (const std::string& text :
       {minimal_, "%YAML:1.0\n---\n" + minimal_, "---\n" + minimal_ + "...\n"}) {
    const FileStatus status = read(text);
    ASSERT_TRUE(status.ok()) << status.message();
    RgbdCamera expected;
    expected.camera.width_px = 640;
    expected.camera.height_px = 480;
    expected.camera.fx_px = 600.5;
    expected.camera.fy_px = 601.0;
    expected.camera.cx_px = 320.0;
    expected.camera.cy_px = 240.0;
    expected.depth_units_per_m = 1000.0;
    expect_same(camera_, expected);
    EXPECT_EQ(camera_.fps, 30.0);
    EXPECT_EQ(camera_.groundtruth_frame, GroundtruthFrame::kCamera);
    EXPECT_EQ(camera_.name, path_);
  }
}

TEST_F(CameraFile, AcceptsCarriageReturnsAndAllKeys) {
  std::string text = minimal_ +
                     "k1: 0.1\nk2: -0.2\np1: 1e-3\np2: -1e-4\nk3: .5\nfps: 15\n"
                     "groundtruth_frame: bonn_marker\n";
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) {
    text.replace(at, 1, "\r\n");
  }
  const FileStatus status = read(text);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(camera_.camera.k1, 0.1);
  EXPECT_EQ(camera_.camera.k2, -0.2);
  EXPECT_EQ(camera_.camera.p1, 1e-3);
  EXPECT_EQ(camera_.camera.p2, -1e-4);
  EXPECT_EQ(camera_.camera.k3, 0.5);
  EXPECT_EQ(camera_.fps, 15.0);
  EXPECT_EQ(camera_.groundtruth_frame, GroundtruthFrame::kBonnMarker);
}

TEST_F(CameraFile, EachRequiredKeyIsMissed) {
  for (const std::string key :
       {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "depth_units_per_m"}) {
    std::string text = minimal_;
    const std::size_t start = text.find(key);
    text.erase(start, text.find('\n', start) - start + 1);
    expect_failure(read(text), StatusCode::kInvalidArgument, path_, 0, "missing key '" + key + "'");
    expect_same(camera_, test::tiny_camera());
  }
  expect_failure(read(""), StatusCode::kInvalidArgument, path_, 0,
                 "missing keys 'width_px', 'height_px', 'fx_px'");
}

TEST_F(CameraFile, RefusesBadKeysAndValuesWithTheirLine) {
  struct Case {
    std::string line;
    std::string reason_part;
    StatusCode code = StatusCode::kInvalidArgument;
  };
  // Each is appended as line 8, so that keys that the file has already would be repeated: those
  // are replaced in place below.
  const std::vector<Case> appended = {
      {"focal: 500", "unknown key 'focal'; known keys: width_px, height_px"},
      {"k4: 0.1", "unknown key 'k4'"},
      {"fx_px: 500", "already given on line 3", StatusCode::kCorruptData},
      {"k1: nan", "value 'nan' of key 'k1' is not a finite decimal number"},
      {"k1: 1e7", "out of range: distortion coefficients must be between -1e6 and 1e6"},
      {"k1: 0.1f", "value '0.1f' of key 'k1'"},
      {"fps: 0", "out of range: fps must be greater than 0 and at most 1000"},
      {"fps: -30", "out of range: fps"},
      {"fps: 1001", "out of range: fps"},
      {"groundtruth_frame: marker", "is not `camera` or `bonn_marker`"},
      {"distortion: [0, 0]", "lists, maps", StatusCode::kCorruptData},
  };
  for (const Case& c : appended) {
    SCOPED_TRACE(c.line);
    expect_failure(read(minimal_ + c.line + "\n"), c.code, path_, 8, c.reason_part);
    expect_same(camera_, test::tiny_camera());
  }
  struct Replacement {
    std::string from;
    std::string to;
    std::size_t line;
    std::string reason_part;
  };
  const std::vector<Replacement> replaced = {
      {"width_px: 640", "width_px: 640.0", 1,
       "value '640.0' of key 'width_px' is not a whole number"},
      {"width_px: 640", "width_px: 0", 1, "out of range: image sides must be 1 to 16384 px"},
      {"height_px: 480", "height_px: 16385", 2, "out of range: image sides"},
      {"height_px: 480", "height_px: -480", 2, "out of range: image sides"},
      {"height_px: 480", "height_px: 99999999999", 2, "is not a whole number"},
      {"fx_px: 600.5", "fx_px: 0", 3, "out of range: focal lengths"},
      {"fx_px: 600.5", "fx_px: -600", 3, "out of range: focal lengths"},
      {"fy_px: 601", "fy_px: 1e6000", 4, "is not a finite decimal number"},
      {"fy_px: 601", "fy_px: \"\"", 4, "value '' of key 'fy_px'"},
      {"cx_px: 320", "cx_px: 1000001", 5, "out of range: the principal point"},
      {"depth_units_per_m: 1000", "depth_units_per_m: 0", 7, "not the inverse"},
      {"depth_units_per_m: 1000", "depth_units_per_m: 0.001", 7, "not the inverse"},
      {"depth_units_per_m: 1000", "depth_units_per_m: -5000", 7, "out of range"},
      {"depth_units_per_m: 1000", "depth_units_per_m: inf", 7, "is not a finite decimal number"},
  };
  for (const Replacement& r : replaced) {
    SCOPED_TRACE(r.to);
    std::string text = minimal_;
    text.replace(text.find(r.from), r.from.size(), r.to);
    expect_failure(read(text), StatusCode::kInvalidArgument, path_, r.line, r.reason_part);
    expect_same(camera_, test::tiny_camera());
  }
}

TEST_F(CameraFile, MissingFileAndFolder) {
  expect_failure(read_camera_file(folder_ / "absent.yaml", &camera_), StatusCode::kNotFound,
                 folder_ / "absent.yaml", 0, "does not exist");
  expect_failure(read_camera_file(folder_.path(), &camera_), StatusCode::kCorruptData,
                 folder_.path(), 0, "is a folder");
}

TEST_F(CameraFile, RoundTripKeepsEveryBit) {
  for (const std::string& name : camera_preset_names()) {
    RgbdCamera preset;
    ASSERT_TRUE(camera_preset(name, &preset).ok());
    ASSERT_TRUE(write_camera_file(path_, preset).ok());
    const FileStatus status = read_camera_file(path_, &camera_);
    ASSERT_TRUE(status.ok()) << status.message();
    expect_same(camera_, preset);
  }
  test::for_each_seed(200, [this](test::Rng& rng) {
    RgbdCamera camera = test::tiny_camera();
    camera.camera.width_px = rng.uniform_int(1, 16384);
    camera.camera.height_px = rng.uniform_int(1, 16384);
    camera.camera.fx_px = rng.uniform(1e-3, 1e6);
    camera.camera.fy_px = rng.uniform(1.0, 2000.0);
    camera.camera.cx_px = rng.uniform(-1e6, 1e6);
    camera.camera.cy_px = rng.uniform(-1e-9, 1e-9);
    camera.camera.k1 = rng.normal();
    camera.camera.k2 = rng.normal() * 1e-300;
    camera.camera.p1 = rng.normal() * 1e5;
    camera.camera.p2 = -0.0;
    camera.camera.k3 = rng.uniform(-1e6, 1e6);
    camera.depth_units_per_m = rng.uniform(1.0, 1e6);
    camera.fps = rng.uniform(1e-6, 1000.0);
    camera.groundtruth_frame =
        rng.coin() ? GroundtruthFrame::kBonnMarker : GroundtruthFrame::kCamera;
    ASSERT_TRUE(write_camera_file(path_, camera).ok());
    RgbdCamera restored;
    const FileStatus status = read_camera_file(path_, &restored);
    ASSERT_TRUE(status.ok()) << status.message();
    expect_same(restored, camera);
    EXPECT_TRUE(std::signbit(restored.camera.p2));
  });
}

TEST_F(CameraFile, WritingReplacesTheFileInOneStepOrNotAtAll) {
  ASSERT_TRUE(write_camera_file(path_, camera_).ok());
  const std::string before = test::read_text(path_);
  EXPECT_FALSE(std::filesystem::exists(path_ + ".partial"));

  RgbdCamera invalid = camera_;
  invalid.depth_units_per_m = 0.0;
  expect_failure(write_camera_file(path_, invalid), StatusCode::kInvalidArgument, path_, 0,
                 "depth_units_per_m");
  EXPECT_EQ(test::read_text(path_), before);

  expect_failure(write_camera_file(folder_ / "absent/camera.yaml", camera_), StatusCode::kIoError,
                 folder_ / "absent/camera.yaml", 0, "cannot be created");
  expect_failure(write_camera_file(folder_.path(), camera_), StatusCode::kIoError, folder_.path(),
                 0, "not a regular file");
  expect_failure(write_camera_file("", camera_), StatusCode::kInvalidArgument, "", 0,
                 "not a file name");
  // A device must stay one.
  expect_failure(write_camera_file("/dev/null", camera_), StatusCode::kIoError, "/dev/null", 0,
                 "not a regular file");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));

  // A link keeps leading to the file.
  const std::string link = folder_ / "link.yaml";
  std::filesystem::create_symlink(path_, link);
  RgbdCamera changed = camera_;
  changed.fps = 12.5;
  ASSERT_TRUE(write_camera_file(link, changed).ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  RgbdCamera restored;
  ASSERT_TRUE(read_camera_file(path_, &restored).ok());
  EXPECT_EQ(restored.fps, 12.5);
}

TEST(RgbdCameraValidate, DefaultIsRefusedAndNaNIsFound) {
  EXPECT_FALSE(RgbdCamera().validate().ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RgbdCamera camera = test::tiny_camera();
  EXPECT_TRUE(camera.validate().ok());
  for (double* value :
       {&camera.camera.fx_px, &camera.camera.fy_px, &camera.camera.cx_px, &camera.camera.cy_px,
        &camera.camera.k1, &camera.camera.k2, &camera.camera.p1, &camera.camera.p2,
        &camera.camera.k3, &camera.depth_units_per_m, &camera.fps}) {
    const double kept = *value;
    *value = nan;
    const Status status = camera.validate();
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument);
    EXPECT_STRNE(status.reason, "");
    *value = kept;
  }
  EXPECT_TRUE(camera.validate().ok());
}

}  // namespace
}  // namespace srslam
