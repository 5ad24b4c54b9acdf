#include "image_container.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

namespace srslam::io_detail {
namespace {

using Bytes = ArrayView<const unsigned char>;

constexpr std::array<unsigned char, 8> kPngSignature = {0x89, 'P',  'N',  'G',
                                                        '\r', '\n', 0x1A, '\n'};

constexpr std::size_t kCrcTables = 8;
using CrcTables = std::array<std::array<std::uint32_t, 256>, kCrcTables>;

/// tables[k][b] is the checksum of byte b followed by k zero bytes, so that eight bytes are taken
/// in one step.
constexpr CrcTables make_crc_tables() {
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0U ? 0xEDB88320U : 0U);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < kCrcTables; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t previous = tables[k - 1][byte];
      tables[k][byte] = (previous >> 8U) ^ tables[0][previous & 0xFFU];
    }
  }
  return tables;
}

constexpr CrcTables kCrc = make_crc_tables();

std::uint32_t big_endian_32(const unsigned char* p) {
  return static_cast<std::uint32_t>(p[0]) << 24U | static_cast<std::uint32_t>(p[1]) << 16U |
         static_cast<std::uint32_t>(p[2]) << 8U | static_cast<std::uint32_t>(p[3]);
}

std::uint32_t little_endian_32(const unsigned char* p) {
  return static_cast<std::uint32_t>(p[3]) << 24U | static_cast<std::uint32_t>(p[2]) << 16U |
         static_cast<std::uint32_t>(p[1]) << 8U | static_cast<std::uint32_t>(p[0]);
}

std::uint32_t big_endian_16(const unsigned char* p) {
  return static_cast<std::uint32_t>(p[0]) << 8U | static_cast<std::uint32_t>(p[1]);
}

std::string at_byte(std::size_t offset) { return " at byte " + std::to_string(offset); }

/// Reads the 13 bytes of an IHDR chunk.
std::string parse_png_header(const unsigned char* data, ImageHeader* header) {
  header->format = ImageFormat::kPng;
  header->width_px = big_endian_32(data);
  header->height_px = big_endian_32(data + 4);
  header->bits_per_channel = data[8];
  const int color_type = data[9];
  header->has_palette = color_type == 3;
  switch (color_type) {
    case 0:
    case 3:
      header->num_channels = 1;
      break;
    case 2:
      header->num_channels = 3;
      break;
    case 4:
      header->num_channels = 2;
      break;
    case 6:
      header->num_channels = 4;
      break;
    default:
      return "PNG header has an unknown colour type; the file is damaged";
  }
  const int bits = header->bits_per_channel;
  const bool is_gray_or_palette = color_type == 0 || color_type == 3;
  const bool bits_valid = bits == 8 || (bits == 16 && color_type != 3) ||
                          (is_gray_or_palette && (bits == 1 || bits == 2 || bits == 4));
  if (header->width_px == 0 || header->height_px == 0 || !bits_valid || data[10] != 0 ||
      data[11] != 0 || data[12] > 1) {
    return "PNG header holds impossible values; the file is damaged";
  }
  return {};
}

std::string inspect_png(Bytes bytes, ImageHeader* header) {
  constexpr std::size_t kChunkOverhead = 12;  // length, type, checksum
  std::size_t offset = kPngSignature.size();
  bool seen_header = false;
  bool seen_palette = false;
  bool seen_data = false;
  bool data_ended = false;
  while (true) {
    if (bytes.size - offset < kChunkOverhead) {
      return "PNG is truncated" + at_byte(bytes.size) + ": no IEND chunk";
    }
    const unsigned char* chunk = bytes.data + offset;
    const std::uint32_t length = big_endian_32(chunk);
    const std::string_view type(reinterpret_cast<const char*>(chunk + 4), 4);
    if (length > bytes.size - offset - kChunkOverhead) {
      return "PNG is truncated: the chunk" + at_byte(offset) + " goes beyond the end of the file";
    }
    const std::uint32_t stored = big_endian_32(chunk + 8 + length);
    if (crc32({chunk + 4, 4 + static_cast<std::size_t>(length)}) != stored) {
      return "PNG is damaged: the chunk" + at_byte(offset) + " has a wrong checksum";
    }
    if (seen_header == (type == "IHDR")) {
      return "PNG is damaged: expected one IHDR chunk, and as the first";
    }
    if (type == "IHDR") {
      if (length != 13) return "PNG is damaged: its IHDR chunk has a wrong length";
      std::string reason = parse_png_header(chunk + 8, header);
      if (!reason.empty()) return reason;
      seen_header = true;
    } else if (type == "IDAT") {
      if (data_ended) return "PNG is damaged: its IDAT chunks are not consecutive";
      seen_data = true;
    } else {
      data_ended = seen_data;
      if (type == "IEND") break;
      const bool is_critical = chunk[4] >= 'A' && chunk[4] <= 'Z';
      if (type == "PLTE") {
        seen_palette = true;
      } else if (is_critical) {
        return "PNG has an unknown critical chunk" + at_byte(offset);
      }
    }
    offset += kChunkOverhead + length;
  }
  if (!seen_data) return "PNG is damaged: it has no IDAT chunk, that is no pixels";
  if (header->has_palette && !seen_palette) return "PNG is damaged: its palette is missing";
  return {};
}

/// Reads a start-of-frame segment, marker 0xFF `marker`, payload without the length field.
std::string parse_jpeg_frame(unsigned char marker, Bytes payload, ImageHeader* header) {
  // 0xC0..0xC2: baseline, extended sequential and progressive Huffman coding.
  if (marker > 0xC2) {
    return "JPEG is lossless, hierarchical or arithmetic-coded, which is not supported";
  }
  if (payload.size < 6) return "JPEG is damaged: its frame header is too short";
  header->format = ImageFormat::kJpeg;
  header->bits_per_channel = payload[0];
  header->height_px = big_endian_16(payload.data + 1);
  header->width_px = big_endian_16(payload.data + 3);
  header->num_channels = payload[5];
  if (header->width_px == 0 || header->height_px == 0 || header->num_channels == 0 ||
      payload.size != 6 + 3 * static_cast<std::size_t>(header->num_channels)) {
    return "JPEG is damaged: its frame header holds impossible values";
  }
  return {};
}

/// Offset of the first marker after the entropy-coded data that starts at `offset`, or the size.
std::size_t skip_jpeg_scan(Bytes bytes, std::size_t offset) {
  while (offset < bytes.size) {
    const void* found = std::memchr(bytes.data + offset, 0xFF, bytes.size - offset);
    if (found == nullptr) break;
    offset = static_cast<std::size_t>(static_cast<const unsigned char*>(found) - bytes.data);
    if (offset + 1 >= bytes.size) break;
    const unsigned char following = bytes[offset + 1];
    const bool is_restart = following >= 0xD0 && following <= 0xD7;
    if (following != 0x00 && following != 0xFF && !is_restart) return offset;
    offset += following == 0xFF ? 1 : 2;
  }
  return bytes.size;
}

std::string inspect_jpeg(Bytes bytes, ImageHeader* header) {
  const auto truncated = [&bytes] {
    return "JPEG is truncated" + at_byte(bytes.size) + ": no end-of-image marker";
  };
  std::size_t offset = 2;
  bool seen_frame = false;
  bool seen_scan = false;
  while (true) {
    if (offset >= bytes.size) return truncated();
    if (bytes[offset] != 0xFF) return "JPEG is damaged: no marker" + at_byte(offset);
    while (offset < bytes.size && bytes[offset] == 0xFF) ++offset;
    if (offset >= bytes.size) return truncated();
    const unsigned char marker = bytes[offset++];
    if (marker == 0xD9) break;
    if (marker == 0x00 || marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {
      return "JPEG is damaged: unexpected marker" + at_byte(offset - 2);
    }
    if (bytes.size - offset < 2) return truncated();
    const std::size_t length = big_endian_16(bytes.data + offset);
    if (length < 2) return "JPEG is damaged: impossible segment length" + at_byte(offset);
    if (length > bytes.size - offset) return truncated();
    const bool is_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) {
      if (seen_frame) return "JPEG is damaged: it has two frame headers";
      std::string reason = parse_jpeg_frame(marker, {bytes.data + offset + 2, length - 2}, header);
      if (!reason.empty()) return reason;
      seen_frame = true;
    }
    offset += length;
    if (marker == 0xDA) {
      if (!seen_frame) return "JPEG is damaged: pixels before the frame header";
      seen_scan = true;
      offset = skip_jpeg_scan(bytes, offset);
    }
  }
  if (!seen_scan) return "JPEG is damaged: it has no pixels";
  return {};
}

}  // namespace

std::uint32_t crc32(ArrayView<const unsigned char> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  const unsigned char* p = bytes.begin();
  std::size_t rest = bytes.size;
  for (; rest >= 8; rest -= 8, p += 8) {
    const std::uint32_t low = crc ^ little_endian_32(p);
    const std::uint32_t high = little_endian_32(p + 4);
    crc = kCrc[7][low & 0xFFU] ^ kCrc[6][low >> 8U & 0xFFU] ^ kCrc[5][low >> 16U & 0xFFU] ^
          kCrc[4][low >> 24U] ^ kCrc[3][high & 0xFFU] ^ kCrc[2][high >> 8U & 0xFFU] ^
          kCrc[1][high >> 16U & 0xFFU] ^ kCrc[0][high >> 24U];
  }
  for (; rest > 0; --rest, ++p) crc = (crc >> 8U) ^ kCrc[0][(crc ^ *p) & 0xFFU];
  return crc ^ 0xFFFFFFFFU;
}

std::string inspect_image(ArrayView<const unsigned char> bytes, ImageHeader* header) {
  *header = ImageHeader();
  if (bytes.size >= kPngSignature.size() &&
      std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin())) {
    return inspect_png(bytes, header);
  }
  if (bytes.size >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF) {
    return inspect_jpeg(bytes, header);
  }
  return "neither a PNG nor a JPEG file by its first bytes";
}

}  // namespace srslam::io_detail
