#include "atlas/gray_png.h"

#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "atlas/atomic_file.h"
#include "atlas/image_io.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

GrayPicture noise(int width, int height) {
  std::mt19937 random(static_cast<unsigned>(width));
  GrayPicture picture = {.width = width, .height = height};
  for (int i = 0; i < width * height; ++i) {
    picture.values.push_back(static_cast<std::uint16_t>(random()));
  }
  return picture;
}

// The picture with the checksum of its header put right.
std::string with_checksum(std::string bytes) {
  const auto* const header = reinterpret_cast<const unsigned char*>(bytes.data() + 12);
  const auto sum = static_cast<std::uint32_t>(crc32(0, header, 17));
  for (int i = 0; i < 4; ++i) {
    bytes[29 + static_cast<std::size_t>(i)] = static_cast<char>(sum >> (24 - 8 * i));
  }
  return bytes;
}

TEST(GrayPng, SixteenBitsAreReadBackAsTheyWereWritten) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(32, 21), std::pair(4, 1), std::pair(1, 3)}) {
    GrayPicture picture = noise(width, height);
    picture.values.front() = 0;
    picture.values.back() = 65535;
    write_file_plainly(folder / "a.png", gray_png_bytes(picture));
    const GrayPicture again = read_gray_png(folder / "a.png");
    EXPECT_EQ(again.width, width);
    EXPECT_EQ(again.height, height);
    EXPECT_EQ(again.values, picture.values);
    EXPECT_EQ(gray_png_bytes(picture), gray_png_bytes(again));
  }
}

TEST(GrayPng, FileHoldsNumbersAndNoColourSpace) {
  // Other chunks than the three that a picture needs might change what a reader makes of it.
  const std::string bytes = gray_png_bytes(noise(32, 9));
  EXPECT_EQ(bytes.substr(12, 4), "IHDR");
  EXPECT_EQ(bytes[24], 16);  // bits
  EXPECT_EQ(bytes[25], 0);   // grey
  for (const char* chunk : {"gAMA", "sRGB", "iCCP", "tIME", "tEXt", "sBIT"}) {
    EXPECT_EQ(bytes.find(chunk), std::string::npos) << chunk;
  }
}

TEST(GrayPng, OtherFilesAreRefusedByName) {
  const TemporaryFolder folder;
  const std::string file = folder / "a.png";
  const auto message = [&](const std::string& bytes) {
    write_file_plainly(file, bytes);
    const std::string text = message_of([&] { read_gray_png(file); });
    EXPECT_THAT(text, StartsWith(file + ": "));
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  };
  const std::string good = gray_png_bytes(noise(32, 40));
  EXPECT_THAT(message(""), HasSubstr("it is not a PNG; expected a whole PNG picture"));
  EXPECT_THAT(message("P5 1 1 255 x"), HasSubstr("it is not a PNG"));
  for (const std::size_t length : {good.size() / 2, std::size_t{20}, std::size_t{8}}) {
    EXPECT_THAT(message(good.substr(0, length)),
                HasSubstr(fmt::format("cannot be read: it ends after {} bytes", length)));
  }
  std::string huge = good;
  huge[16] = 0x7f;  // width
  EXPECT_THAT(message(huge), HasSubstr("cannot be read: wrong checksum at byte 8"));
  huge = with_checksum(huge);
  EXPECT_THAT(message(huge), HasSubstr("cannot be read: 2130706464 x 40 pixels in"));
  std::string flipped = good;
  flipped[200] = static_cast<char>(flipped[200] ^ 1);
  EXPECT_THAT(message(flipped), HasSubstr("cannot be read: wrong checksum at byte "));
  std::string other = good;
  other.replace(12, 4, "JHDR");
  EXPECT_THAT(message(with_checksum(other)), HasSubstr("it does not begin with a header"));
  write_png(folder / "b.png", make_image(4, 4));
  EXPECT_THAT(message(read_file(folder / "b.png")),
              HasSubstr("8 bits of colour type 0; expected 16 bits of grey (type 0)"));
  write_png(folder / "b.png", make_image(4, 4, 3));
  EXPECT_THAT(message(read_file(folder / "b.png")), HasSubstr("8 bits of colour type 2"));
  EXPECT_THAT(message_of([&] { read_gray_png(folder / "none.png"); }),
              HasSubstr("none.png: cannot read: No such file or directory"));
  EXPECT_THAT(message_of([] { gray_png_bytes({.width = 2, .height = 2, .values = {1}}); }),
              HasSubstr("2 x 2 pixels with 1 values"));
}

}  // namespace
}  // namespace pluvia
