#include "raytrace/reference_files.h"

#include <gtest/gtest.h>

#include "atlas/atomic_file.h"
#include "atlas/exr_parts.h"
#include "atlas/image_io.h"
#include "tests/reference_samples.h"
#include "tests/temporary_folder.h"

namespace pluvia {
namespace {

std::unique_ptr<ReferenceScene> lit_drop(double lamp_cd = 60) {
  Scene scene = dark_scene(8, 12);
  scene.environment.uniform_cd_m2 = {0.5, 0.6, 0.7};
  scene.lights = {
      {.name = "lamp", .position_m = {0.3, 4, 1}, .intensity_cd = {lamp_cd, lamp_cd, lamp_cd}}};
  return reference_scene(scene, {falling_drop(scene, {0, 1, 0.05}, {0, 0, -8.49}, 3)});
}

constexpr ReferenceSettings settings = {.learning_passes = 3};

ReferenceSums after(const ReferenceScene& scene, ReferenceSums sums, int passes) {
  for (int k = 0; k < passes; ++k) add_pass(scene, settings, sums);
  return sums;
}

TEST(ReferenceFiles, SumsThatWereSavedAtAnyPassGoOnToTheSameBytes) {
  const TemporaryFolder folder;
  const auto scene = lit_drop();
  const std::string print = reference_fingerprint(*scene, settings);
  write_reference(folder / "whole.exr", after(*scene, empty_sums(*scene), 8));
  for (int broken = 0; broken <= 8; ++broken) {
    write_sums(folder / "sums", print, after(*scene, empty_sums(*scene), broken));
    const ReferenceSums read = read_sums(folder / "sums", print);
    EXPECT_EQ(read.learned, std::min(broken, 3));
    write_reference(folder / "resumed.exr", after(*scene, read, 8 - broken));
    EXPECT_EQ(read_file(folder / "resumed.exr"), read_file(folder / "whole.exr")) << broken;
  }
}

TEST(ReferenceFiles, ThePictureHasMeansVariancesAndTheRainAlone) {
  const TemporaryFolder folder;
  const auto scene = lit_drop();
  const ReferenceSums sums = after(*scene, empty_sums(*scene), 8);
  write_reference(folder / "a.exr", sums);
  const auto parts = parse_exr("a.exr", read_file(folder / "a.exr"));
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].attributes.at("passes"), 5);
  std::map<std::string, std::vector<float>> channels;
  for (const ExrChannel& channel : parts[0].channels) channels[channel.name] = channel.values;
  const ReferenceLayer rain = layer_of(sums.rain, sums.rain_squares, sums.passes);
  const ReferenceLayer surface = layer_of(sums.surface, sums.surface_squares, sums.passes);
  for (std::size_t i = 0; i < sums.coverage.size(); ++i) {
    const std::size_t g = 3 * i + 1;
    EXPECT_FLOAT_EQ(channels.at("G")[i], static_cast<float>(surface.mean[g] + rain.mean[g]));
    EXPECT_FLOAT_EQ(channels.at("rain.G")[i], static_cast<float>(rain.mean[g]));
    EXPECT_FLOAT_EQ(channels.at("rain.variance.G")[i], static_cast<float>(rain.variance[g]));
    EXPECT_FLOAT_EQ(channels.at("coverage")[i], static_cast<float>(sums.coverage[i] / 5));
    EXPECT_GE(channels.at("variance.G")[i], channels.at("rain.variance.G")[i]);
    EXPECT_GE(channels.at("samples")[i], 5 * 4);
  }
  const Image image = read_image(folder / "a.exr");
  EXPECT_EQ(image.at(3, 5, 1), channels.at("G")[5 * 8 + 3]) << "any reader finds the picture first";
}

TEST(ReferenceFiles, SumsOfAnotherPictureOrDamagedOnesAreRefused) {
  const TemporaryFolder folder;
  const auto scene = lit_drop();
  const std::string print = reference_fingerprint(*scene, settings);
  EXPECT_NE(print, reference_fingerprint(*lit_drop(61), settings));
  EXPECT_NE(print, reference_fingerprint(*scene, {.learning_passes = 3, .seed = 2}));
  EXPECT_EQ(print, reference_fingerprint(*lit_drop(), {.error = 0.3, .learning_passes = 3}));
  write_sums(folder / "sums", print, empty_sums(*scene));
  const std::string bytes = read_file(folder / "sums");
  EXPECT_EQ(
      message_of([&] { read_sums(folder / "sums", std::string(64, '0')); }),
      folder / "sums" + std::string(": sums of another picture; expected those of this scene, "
                                    "frame and flags, or no such file"));
  for (const std::size_t at : {bytes.size() - 1, bytes.size() / 2, std::size_t{30}}) {
    std::string cut = bytes.substr(0, at), changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    for (const std::string& bad : {cut, changed}) {
      write_file_atomically(folder / "sums", bad);
      EXPECT_NE(message_of([&] { read_sums(folder / "sums", print); }), "") << at;
    }
  }
}

}  // namespace
}  // namespace pluvia
