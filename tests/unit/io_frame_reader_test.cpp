#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "srslam/io/tum_dataset.hpp"
#include "support/io_test_dataset.hpp"

namespace srslam {
namespace {

using test::TempFolder;
using test::tiny_camera;
using test::tiny_color_file;

class FrameReaderTest : public testing::Test {
 protected:
  void make(int num_frames) {
    test::write_tiny_dataset(folder_.path(), num_frames);
    const FileStatus status = TumDataset::open(folder_.path(), {}, &dataset_);
    ASSERT_TRUE(status.ok()) << status.message();
  }

  TempFolder folder_;
  TumDataset dataset_;
  LoadedFrame frame_;
};

TEST_F(FrameReaderTest, HandsOutTheSameFramesAsLoadInOrder) {
  make(12);
  struct Range {
    std::size_t first;
    std::size_t last;
    std::size_t expected_last;
  };
  for (const Range& range :
       {Range{0, 12, 12}, Range{3, 7, 7}, Range{5, 1000, 12}, Range{11, 12, 12}, Range{4, 4, 4},
        Range{12, 12, 12}, Range{7, 3, 7}, Range{50, 60, 50}}) {
    for (const std::size_t read_ahead : {0U, 1U, 2U, 4U, 100U}) {
      SCOPED_TRACE(std::to_string(range.first) + ".." + std::to_string(range.last) + " ahead " +
                   std::to_string(read_ahead));
      FrameReader reader(dataset_, tiny_camera(), range.first, range.last, read_ahead);
      for (std::size_t i = range.first; i < range.expected_last; ++i) {
        ASSERT_TRUE(reader.next(&frame_));
        ASSERT_TRUE(frame_.status.ok()) << frame_.status.message();
        ASSERT_EQ(frame_.index, i);
        LoadedFrame direct;
        ASSERT_TRUE(dataset_.load(i, tiny_camera(), &direct).ok());
        ASSERT_EQ(frame_.timestamp_s, direct.timestamp_s);
        ASSERT_EQ(frame_.has_depth, direct.has_depth);
        ASSERT_EQ(frame_.gray.pixels, direct.gray.pixels);
        ASSERT_EQ(frame_.depth_m.pixels, direct.depth_m.pixels);
      }
      EXPECT_FALSE(reader.next(&frame_));
      EXPECT_FALSE(reader.next(&frame_));
    }
  }
}

TEST_F(FrameReaderTest, ADamagedFrameIsHandedOutWithItsReasonAndTheRestFollows) {
  make(6);
  const std::string damaged = folder_ / tiny_color_file(3);
  std::filesystem::resize_file(damaged, 50);
  for (const std::size_t read_ahead : {0U, 2U}) {
    FrameReader reader(dataset_, tiny_camera(), 0, 6, read_ahead);
    for (std::size_t i = 0; i < 6; ++i) {
      ASSERT_TRUE(reader.next(&frame_));
      EXPECT_EQ(frame_.index, i);
      EXPECT_EQ(frame_.timestamp_s, dataset_.entry(i).timestamp_s);
      if (i == 3) {
        test::expect_failure(frame_.status, StatusCode::kCorruptData, damaged, 0, "truncated");
        EXPECT_TRUE(frame_.gray.empty());
        EXPECT_FALSE(frame_.has_depth);
      } else {
        EXPECT_TRUE(frame_.status.ok()) << frame_.status.message();
        EXPECT_FALSE(frame_.gray.empty());
      }
    }
    EXPECT_FALSE(reader.next(&frame_));
  }
}

TEST_F(FrameReaderTest, ReadsAheadNoFurtherThanAllowed) {
  make(20);
  FrameReader reader(dataset_, tiny_camera(), 0, 20, 2);
  // Time enough to decode all twenty, if the reader went on. What it had not read yet when the
  // files vanish cannot be handed out.
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  for (int i = 2; i < 20; ++i) std::filesystem::remove(folder_ / tiny_color_file(i));
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(reader.next(&frame_));
    EXPECT_EQ(frame_.status.ok(), i < 2) << i;
    EXPECT_EQ(frame_.status.code, i < 2 ? StatusCode::kOk : StatusCode::kNotFound) << i;
  }
}

TEST_F(FrameReaderTest, BuffersAreRecycled) {
  make(40);
  constexpr std::size_t kReadAhead = 3;
  FrameReader reader(dataset_, tiny_camera(), 0, 40, kReadAhead);
  std::set<const void*> gray;
  std::set<const void*> depth;
  while (reader.next(&frame_)) {
    gray.insert(frame_.gray.pixels.data());
    depth.insert(frame_.depth_m.pixels.data());
  }
  EXPECT_EQ(gray.size(), kReadAhead + 1);
  EXPECT_EQ(depth.size(), kReadAhead + 1);
}

TEST_F(FrameReaderTest, CanBeDestroyedAtAnyTime) {
  make(10);
  for (std::size_t num_taken = 0; num_taken <= 10; ++num_taken) {
    for (const std::size_t read_ahead : {0U, 1U, 4U, 20U}) {
      auto reader = std::make_unique<FrameReader>(dataset_, tiny_camera(), 0, 10, read_ahead);
      for (std::size_t i = 0; i < num_taken; ++i) ASSERT_TRUE(reader->next(&frame_));
      reader.reset();
    }
  }
}

TEST_F(FrameReaderTest, ABadCameraFailsEveryFrame) {
  make(3);
  FrameReader reader(dataset_, RgbdCamera(), 0, 3, 2);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(reader.next(&frame_));
    EXPECT_EQ(frame_.status.code, StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(reader.next(&frame_));
}

}  // namespace
}  // namespace srslam
