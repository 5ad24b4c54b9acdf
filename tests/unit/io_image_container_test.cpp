#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "io/image_container.hpp"
#include "support/io_test_dataset.hpp"
#include "support/rng.hpp"

namespace srslam {
namespace {

using io_detail::ImageFormat;
using io_detail::ImageHeader;
using io_detail::inspect_image;
using Bytes = std::vector<unsigned char>;

Bytes encode(const std::string& extension, const cv::Mat& image,
             const std::vector<int>& parameters = {}) {
  Bytes bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, parameters));
  return bytes;
}

void append_big_endian_32(std::uint32_t value, Bytes* bytes) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) {
    bytes->push_back(static_cast<unsigned char>(value >> shift & 0xFFU));
  }
}

/// Appends a PNG chunk with a correct checksum.
void append_chunk(const std::string& type, const Bytes& data, Bytes* bytes) {
  append_big_endian_32(static_cast<std::uint32_t>(data.size()), bytes);
  Bytes checked(type.begin(), type.end());
  checked.insert(checked.end(), data.begin(), data.end());
  bytes->insert(bytes->end(), checked.begin(), checked.end());
  append_big_endian_32(io_detail::crc32(checked), bytes);
}

Bytes png_start() { return {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'}; }

Bytes png_header(std::uint32_t width_px, std::uint32_t height_px, unsigned char bits,
                 unsigned char color_type) {
  Bytes data;
  append_big_endian_32(width_px, &data);
  append_big_endian_32(height_px, &data);
  data.insert(data.end(), {bits, color_type, 0, 0, 0});
  return data;
}

TEST(Crc32, MatchesTheStandardsCheckValueAndTheDefinition) {
  const std::string check = "123456789";
  EXPECT_EQ(io_detail::crc32(Bytes(check.begin(), check.end())), 0xCBF43926U);
  EXPECT_EQ(io_detail::crc32(Bytes()), 0U);
  test::for_each_seed(100, [](test::Rng& rng) {
    Bytes bytes(static_cast<std::size_t>(rng.uniform_int(0, 100)));
    std::uint32_t expected = 0xFFFFFFFFU;
    for (unsigned char& byte : bytes) {
      byte = static_cast<unsigned char>(rng.next() & 0xFFU);
      expected ^= byte;
      for (int bit = 0; bit < 8; ++bit) {
        expected = (expected >> 1U) ^ ((expected & 1U) != 0U ? 0xEDB88320U : 0U);
      }
    }
    ASSERT_EQ(io_detail::crc32(bytes), expected ^ 0xFFFFFFFFU);
  });
}

TEST(ImageContainer, ReadsHeaders) {
  struct Case {
    Bytes bytes;
    ImageFormat format;
    int bits;
    int channels;
  };
  const cv::Mat gray8(30, 40, CV_8UC1, cv::Scalar(7));
  const cv::Mat gray16(30, 40, CV_16UC1, cv::Scalar(700));
  const cv::Mat rgba8(30, 40, CV_8UC4, cv::Scalar(1, 2, 3, 4));
  const std::vector<Case> cases = {
      {encode(".png", gray8), ImageFormat::kPng, 8, 1},
      {encode(".png", gray16), ImageFormat::kPng, 16, 1},
      {encode(".png", test::tiny_color(0)), ImageFormat::kPng, 8, 3},
      {encode(".png", rgba8), ImageFormat::kPng, 8, 4},
      {encode(".jpg", gray8), ImageFormat::kJpeg, 8, 1},
      {encode(".jpg", test::tiny_color(0)), ImageFormat::kJpeg, 8, 3},
      {encode(".jpg", test::tiny_color(0), {cv::IMWRITE_JPEG_PROGRESSIVE, 1}), ImageFormat::kJpeg,
       8, 3},
      {encode(".jpg", test::tiny_color(0), {cv::IMWRITE_JPEG_RST_INTERVAL, 1}), ImageFormat::kJpeg,
       8, 3},
  };
  for (const Case& c : cases) {
    ImageHeader header;
    EXPECT_EQ(inspect_image(c.bytes, &header), "");
    EXPECT_EQ(header.format, c.format);
    EXPECT_EQ(header.width_px, 40U);
    EXPECT_EQ(header.height_px, 30U);
    EXPECT_EQ(header.bits_per_channel, c.bits);
    EXPECT_EQ(header.num_channels, c.channels);
    EXPECT_FALSE(header.has_palette);
  }
}

TEST(ImageContainer, EveryTruncationIsFound) {
  for (const Bytes& whole :
       {encode(".png", test::tiny_depth(0)), encode(".jpg", test::tiny_color(0)),
        encode(".jpg", test::tiny_color(0), {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
        encode(".jpg", test::tiny_color(0), {cv::IMWRITE_JPEG_RST_INTERVAL, 1})}) {
    ImageHeader header;
    ASSERT_EQ(inspect_image(whole, &header), "");
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const std::string reason = inspect_image(cut, &header);
      ASSERT_NE(reason, "") << size << " of " << whole.size() << " bytes";
      if (size >= 8) {
        ASSERT_NE(reason.find("truncated"), std::string::npos) << reason;
      }
    }
  }
}

TEST(ImageContainer, EveryFlippedBitOfAPngIsFound) {
  const Bytes whole = encode(".png", test::tiny_depth(0));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      Bytes flipped = whole;
      flipped[i] = static_cast<unsigned char>(flipped[i] ^ (1U << bit));
      ImageHeader header;
      ASSERT_NE(inspect_image(flipped, &header), "") << "byte " << i << " bit " << bit;
    }
  }
}

TEST(ImageContainer, DamageToPngStructureIsNamed) {
  const Bytes header_data = png_header(40, 30, 8, 0);
  const Bytes pixels = {1, 2, 3};
  struct Case {
    std::vector<std::pair<std::string, Bytes>> chunks;
    std::string reason_part;
  };
  const std::vector<Case> cases = {
      {{{"IHDR", header_data}, {"IDAT", pixels}, {"tEXt", {}}, {"IEND", {}}}, ""},
      {{{"IHDR", header_data}, {"IDAT", pixels}, {"IDAT", pixels}, {"IEND", {}}}, ""},
      {{{"IHDR", png_header(40, 30, 8, 3)}, {"PLTE", {0, 0, 0}}, {"IDAT", pixels}, {"IEND", {}}},
       ""},
      {{{"IHDR", header_data}, {"IEND", {}}}, "no IDAT chunk"},
      {{{"IDAT", pixels}, {"IHDR", header_data}, {"IEND", {}}}, "one IHDR chunk, and as the first"},
      {{{"IHDR", header_data}, {"IHDR", header_data}, {"IEND", {}}}, "one IHDR chunk"},
      {{{"IHDR", pixels}, {"IDAT", pixels}, {"IEND", {}}}, "IHDR chunk has a wrong length"},
      {{{"IHDR", header_data}, {"IDAT", pixels}, {"tEXt", {}}, {"IDAT", pixels}, {"IEND", {}}},
       "not consecutive"},
      {{{"IHDR", header_data}, {"ABCD", {}}, {"IDAT", pixels}, {"IEND", {}}},
       "unknown critical chunk"},
      {{{"IHDR", png_header(40, 30, 8, 3)}, {"IDAT", pixels}, {"IEND", {}}}, "palette is missing"},
      {{{"IHDR", png_header(0, 30, 8, 0)}, {"IDAT", pixels}, {"IEND", {}}}, "impossible values"},
      {{{"IHDR", png_header(40, 0, 8, 0)}, {"IDAT", pixels}, {"IEND", {}}}, "impossible values"},
      {{{"IHDR", png_header(40, 30, 5, 0)}, {"IDAT", pixels}, {"IEND", {}}}, "impossible values"},
      {{{"IHDR", png_header(40, 30, 16, 3)}, {"IDAT", pixels}, {"IEND", {}}}, "impossible values"},
      {{{"IHDR", png_header(40, 30, 8, 5)}, {"IDAT", pixels}, {"IEND", {}}}, "unknown colour type"},
      {{{"IHDR", header_data}, {"IDAT", pixels}}, "no IEND chunk"},
  };
  for (const Case& c : cases) {
    Bytes bytes = png_start();
    for (const auto& [type, data] : c.chunks) append_chunk(type, data, &bytes);
    ImageHeader header;
    const std::string reason = inspect_image(bytes, &header);
    if (c.reason_part.empty()) {
      EXPECT_EQ(reason, "");
    } else {
      EXPECT_NE(reason.find(c.reason_part), std::string::npos) << reason;
    }
  }
}

TEST(ImageContainer, DamageToJpegStructureIsNamed) {
  const Bytes whole = encode(".jpg", test::tiny_color(0));
  ImageHeader header;
  // A thumbnail's end marker inside a segment is not the end of the image.
  Bytes with_thumbnail = whole;
  const Bytes segment = {0xFF, 0xE1, 0x00, 0x06, 0xFF, 0xD8, 0xFF, 0xD9};
  with_thumbnail.insert(with_thumbnail.begin() + 2, segment.begin(), segment.end());
  EXPECT_EQ(inspect_image(with_thumbnail, &header), "");
  with_thumbnail.resize(with_thumbnail.size() - 2);
  EXPECT_NE(inspect_image(with_thumbnail, &header).find("truncated"), std::string::npos);

  const auto frame_header = [&whole] {
    for (std::size_t i = 2; i + 1 < whole.size(); ++i) {
      if (whole[i] == 0xFF && whole[i + 1] == 0xC0) return i;
    }
    return whole.size();
  }();
  ASSERT_LT(frame_header, whole.size());
  const auto changed = [&whole](std::size_t at, unsigned char value) {
    Bytes bytes = whole;
    bytes[at] = value;
    return bytes;
  };
  EXPECT_NE(inspect_image(changed(frame_header + 1, 0xC3), &header).find("lossless"),
            std::string::npos);
  EXPECT_NE(inspect_image(changed(frame_header + 1, 0xC9), &header).find("arithmetic"),
            std::string::npos);
  EXPECT_NE(inspect_image(changed(frame_header + 1, 0xD8), &header).find("unexpected marker"),
            std::string::npos);
  EXPECT_NE(inspect_image(changed(frame_header, 0x00), &header).find("no marker at byte"),
            std::string::npos);
  EXPECT_NE(inspect_image(changed(frame_header + 9, 7), &header).find("impossible values"),
            std::string::npos);
  Bytes no_height = whole;
  no_height[frame_header + 5] = 0;
  no_height[frame_header + 6] = 0;
  EXPECT_NE(inspect_image(no_height, &header).find("impossible values"), std::string::npos);

  EXPECT_NE(inspect_image(Bytes{0xFF, 0xD8, 0xFF, 0xD9}, &header).find("no pixels"),
            std::string::npos);
  EXPECT_NE(inspect_image(Bytes{0xFF, 0xD8, 0xFF, 0xDA, 0, 2, 0xFF, 0xD9}, &header)
                .find("before the frame header"),
            std::string::npos);
  EXPECT_NE(inspect_image(Bytes{0xFF, 0xD8, 0xFF, 0xE0, 0, 1, 0, 0}, &header)
                .find("impossible segment length"),
            std::string::npos);
}

TEST(ImageContainer, OtherFilesAreNamed) {
  ImageHeader header;
  for (const Bytes& bytes : {Bytes{}, Bytes{'B', 'M', 0, 0}, Bytes(100, 0), Bytes(100, 0xFF)}) {
    EXPECT_EQ(inspect_image(bytes, &header), "neither a PNG nor a JPEG file by its first bytes");
  }
}

TEST(ImageContainer, RandomDamageNeverReadsOutsideTheBytes) {
  const Bytes png = encode(".png", test::tiny_depth(0));
  const Bytes jpeg = encode(".jpg", test::tiny_color(0));
  test::for_each_seed(3000, [&](test::Rng& rng) {
    Bytes bytes = rng.coin() ? png : jpeg;
    const int num_changes = rng.uniform_int(1, 20);
    for (int i = 0; i < num_changes; ++i) {
      // Near the start, where the structure is.
      const int last = rng.coin() ? 199 : static_cast<int>(bytes.size()) - 1;
      bytes[static_cast<std::size_t>(rng.uniform_int(2, last))] =
          static_cast<unsigned char>(rng.coin() ? 0xFFU : rng.next() & 0xFFU);
    }
    bytes.resize(static_cast<std::size_t>(rng.uniform_int(0, static_cast<int>(bytes.size()))));
    bytes.shrink_to_fit();
    ImageHeader header;
    const std::string reason = inspect_image(bytes, &header);
    if (reason.empty()) {
      ASSERT_GT(header.width_px, 0U);
      ASSERT_GT(header.height_px, 0U);
      ASSERT_GT(header.num_channels, 0);
    }
  });
}

}  // namespace
}  // namespace srslam
