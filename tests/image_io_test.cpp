#include "atlas/image_io.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

std::string environment(const std::string& name) {
  return std::string(PLUVIA_SOURCE_DIR) + "/data/environments/" + name;
}

Image random_image(int width, int height, int channels) {
  Image image = make_image(width, height, channels);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-2, 1000);
  for (float& v : image.values) v = value(random);
  return image;
}

Image constant_map(int height, float value) {
  Image map = make_image(2 * height, height, 3);
  for (float& v : map.values) v = value;
  return map;
}

TEST(ImageIo, ExrKeepsEveryFloatOfOneThreeAndFourChannels) {
  const TemporaryFolder folder;
  for (const int channels : {1, 3, 4}) {
    Image image = random_image(13, 7, channels);
    image.at(0, 0) = 1e-40f;  // denormal
    image.at(12, 6) = -3e38f;
    write_exr(folder / "image.exr", image);
    const Image again = read_image(folder / "image.exr");
    EXPECT_EQ(again.width, 13);
    EXPECT_EQ(again.height, 7);
    EXPECT_EQ(again.channels, channels);
    EXPECT_EQ(again.values, image.values) << channels << " channels";
  }
}

TEST(ImageIo, ExrBytesDoNotDependOnWhenTheyAreWritten) {
  const TemporaryFolder folder;
  const Image image = random_image(20, 20, 3);
  write_exr(folder / "a.exr", image);
  write_exr(folder / "b.exr", image);
  EXPECT_EQ(sha256(read_file(folder / "a.exr")), sha256(read_file(folder / "b.exr")));
}

TEST(ImageIo, PicturesThatExrCannotHoldAreRefused) {
  const TemporaryFolder folder;
  const auto write = [&](const Image& image) { write_exr(folder / "x.exr", image); };
  EXPECT_THAT(message_of([&] { write(make_image(2, 2, 2)); }), HasSubstr("2 channels"));
  EXPECT_THAT(message_of([&] { write(make_image(0, 2, 1)); }), HasSubstr("0 x 2 pixels"));
  Image image = make_image(4, 3, 3);
  image.at(2, 1, 1) = not_a_number;
  EXPECT_THAT(message_of([&] { write(image); }),
              HasSubstr("x.exr: pixel (2, 1) channel 1 is nan; expected finite values"));
  image.values.pop_back();
  EXPECT_THAT(message_of([&] { write(image); }), HasSubstr("35 values"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ImageIo, PngShowsLinearValuesOnTheSrgbCurve) {
  // 0.2140 is middle grey, 0.5 on the curve: 127.5 -> 127 or 128. 0.0031308 ends the straight
  // piece: 12.92 * 0.0031308 * 255 = 10.31 -> 10. Above white is white, below black is black.
  const TemporaryFolder folder;
  Image image = make_image(5, 1);
  image.values = {0, 0.0031308f, 0.214041f, 1, 7};
  write_png(folder / "a.png", image);
  const Image shown = read_image(folder / "a.png");
  ASSERT_EQ(shown.values.size(), 5u);
  EXPECT_EQ(shown.values[0], 0);
  EXPECT_NEAR(shown.values[1] * 255, 10, 1e-3);
  EXPECT_NEAR(shown.values[2] * 255, 127.5, 0.501);
  EXPECT_EQ(shown.values[3], 1);
  EXPECT_EQ(shown.values[4], 1);
  for (float& v : image.values) v *= 10;
  write_png(folder / "b.png", image, 10);
  EXPECT_EQ(read_file(folder / "b.png"), read_file(folder / "a.png"));
}

TEST(ImageIo, PngBytesAreTheBytesOfThePngFile) {
  const TemporaryFolder folder;
  const Image image = random_image(9, 5, 3);
  write_png(folder / "a.png", image, 500);
  const std::vector<unsigned char> bytes = png_bytes(image, 500);
  EXPECT_EQ(read_file(folder / "a.png"), std::string(bytes.begin(), bytes.end()));
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "\x89PNG");
}

TEST(ImageIo, PngOfInfinityOrWithoutAWhiteIsRefused) {
  const TemporaryFolder folder;
  Image image = make_image(2, 2);
  EXPECT_THAT(message_of([&] { write_png(folder / "x.png", image, 0); }), HasSubstr("white = 0"));
  EXPECT_THAT(message_of([&] { write_png(folder / "x.png", image, infinity); }),
              HasSubstr("white = inf"));
  EXPECT_THAT(message_of([&] { write_png(folder / "x.png", make_image(2, 2, 4)); }),
              HasSubstr("4 channels"));
  image.at(1, 0) = infinity;
  EXPECT_THAT(message_of([&] { write_png(folder / "x.png", image); }),
              HasSubstr("pixel (1, 0) channel 0 is inf"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ImageIo, UnwritablePlacesAreRefusedByName) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "plain", "x");
  EXPECT_THAT(message_of([&] { write_exr(folder / "plain/a.exr", make_image(2, 2)); }),
              HasSubstr("plain/a.exr: cannot write: Not a directory"));
  EXPECT_THAT(message_of([&] { write_png(folder / "plain/a.png", make_image(2, 2)); }),
              HasSubstr("plain/a.png: cannot write: Not a directory"));
}

TEST(ImageIo, MissingEmptyAndForeignFilesAreRefusedByName) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "empty.exr", "");
  write_file_atomically(folder / "text.exr", "this is no picture");
  for (const std::string name : {"none.exr", "empty.exr", "text.exr"}) {
    const std::string message = message_of([&] { read_image(folder / name); });
    EXPECT_THAT(message, StartsWith((folder / name) + ": cannot ")) << name;
    EXPECT_THAT(message, HasSubstr("; expected a ")) << name;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(ImageIo, TruncatedPicturesAreRefusedByName) {
  const TemporaryFolder folder;
  const Image image = random_image(64, 64, 3);
  write_exr(folder / "whole.exr", image);
  write_png(folder / "whole.png", image, 1000);
  for (const std::string extension : {".exr", ".png"}) {
    const std::string bytes = read_file(folder / ("whole" + extension));
    std::mt19937 random(3);
    for (int i = 0; i < 30; ++i) {
      // The last 12 bytes of a PNG are its end mark: no pixel is missing without them.
      const std::size_t length = random() % (bytes.size() - 12);
      write_file_atomically(folder / ("cut" + extension), bytes.substr(0, length));
      const std::string message = message_of([&] { read_image(folder / ("cut" + extension)); });
      EXPECT_THAT(message, StartsWith(folder / ("cut" + extension))) << length << " bytes";
    }
  }
}

TEST(ImageIo, NotANumberInAFileIsRefusedWithItsPixel) {
  // The file is made finite and then given a NaN: 1234.5 in little-endian bytes becomes 0x7fc00000.
  // One pixel does not shrink under ZIP, and OpenEXR then stores it as it is.
  const TemporaryFolder folder;
  Image image = make_image(1, 1);
  image.at(0, 0) = 1234.5f;
  write_exr(folder / "a.exr", image);
  std::string bytes = read_file(folder / "a.exr");
  const std::size_t place = bytes.rfind(std::string("\x00\x50\x9a\x44", 4));
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place, 4, std::string("\x00\x00\xc0\x7f", 4));
  write_file_atomically(folder / "a.exr", bytes);
  EXPECT_EQ(message_of([&] { read_image(folder / "a.exr"); }),
            (folder / "a.exr") + ": pixel (0, 0) channel 0 is nan; expected finite values");
}

TEST(ImageIo, CleanedEnvironmentMapsAreReadAndTheRawOneIsRefusedWithItsPixel) {
  for (const std::string name : {"city.exr", "night.exr", "park.exr"}) {
    const Image map = read_environment_map(environment(name));
    EXPECT_EQ(map.channels, 3) << name;
    EXPECT_EQ(map.width, 2 * map.height) << name;
  }
  // The first negative value in reading order is the burnt-out sun's upper edge (see the README
  // there).
  EXPECT_EQ(
      message_of([&] { read_environment_map(environment("raw_park.exr")); }),
      environment("raw_park.exr") + ": pixel (305, 110) channel 2 = -16.90625; expected >= 0");
}

TEST(ImageIo, EnvironmentMapThatIsDarkOrOfAnotherShapeIsRefused) {
  const TemporaryFolder folder;
  const std::string file = folder / "map.exr";
  const auto message = [&](const Image& image) {
    write_exr(file, image);
    return message_of([&] { read_environment_map(file); });
  };
  EXPECT_EQ(message(constant_map(4, 0)), file + ": all pixels are 0; expected some light");
  EXPECT_THAT(message(make_image(8, 8, 3)), HasSubstr("8 x 8 pixels, 3 channels; expected width"));
  EXPECT_THAT(message(make_image(8, 4, 1)), HasSubstr("8 x 4 pixels, 1 channels; expected width"));
  write_file_atomically(file, "");
  EXPECT_THAT(message_of([&] { read_environment_map(file); }),
              HasSubstr("map.exr: cannot be read: it is empty"));
  EXPECT_THAT(message_of([&] { read_environment_map(folder / "none.exr"); }),
              HasSubstr("none.exr: cannot read: No such file or directory"));
}

TEST(ImageIo, FourthChannelOfAnEnvironmentMapIsLeftOut) {
  const TemporaryFolder folder;
  Image map = make_image(4, 2, 4);
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    map.values[i] = i % 4 == 3 ? 1.0f : static_cast<float>(i);
  }
  write_exr(folder / "a.exr", map);
  const Image read = read_environment_map(folder / "a.exr");
  EXPECT_EQ(read.channels, 3);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(read.at(3, 1, c), map.at(3, 1, c));
}

TEST(ImageIo, WholeNumbersOfAnEnvironmentMapAreMadeLinear) {
  // A PNG rounds to half of a step, 1/510, of the encoded value, which moves the linear one by less
  // than 1/510 times the encoding's greatest slope, 2.28.
  const TemporaryFolder folder;
  Image map = make_image(8, 4, 3);
  for (std::size_t i = 0; i < map.values.size(); ++i)
    map.values[i] = static_cast<float>(i + 1) / static_cast<float>(map.values.size());
  write_png(folder / "map.png", map);
  write_exr(folder / "map.exr", map);
  const Image png = read_environment_map(folder / "map.png");
  const Image exr = read_environment_map(folder / "map.exr");
  EXPECT_EQ(exr.values, map.values);
  for (std::size_t i = 0; i < map.values.size(); ++i)
    EXPECT_NEAR(png.values[i], map.values[i], 2.28 / 510) << i;
}

TEST(ImageIo, MeanOfAUniformSphereIsItsRadiance) {
  // Weights telescope to exactly 1; summing 2 n^2 of them rounds to about 1e-16 sqrt(2 n^2) <
  // 1e-13.
  for (const int height : {1, 2, 31, 256}) {
    for (const double mean : mean_over_sphere(constant_map(height, 3))) {
      EXPECT_NEAR(mean, 3, 1e-12) << height << " rows";
    }
  }
}

TEST(ImageIo, MeanWeighsPixelsBySolidAngleAndChannelsApart) {
  // Light above elevation 30 deg only (the top third of 90 rows): a share (1 - sin 30 deg) / 2 =
  // 1/4.
  Image map = make_image(180, 90, 3);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < map.width; ++x) map.at(x, y, 1) = 8;
  }
  const std::vector<double> mean = mean_over_sphere(map);
  EXPECT_EQ(mean[0], 0);
  EXPECT_NEAR(mean[1], 2, 1e-12);
  EXPECT_EQ(mean[2], 0);
}

}  // namespace
}  // namespace pluvia
