// A picture in memory. Row 0 is the top, column 0 the left; channels interleaved.
// Values are linear and scene-referred (never gamma-encoded); their unit is told by whoever made
// it.
#pragma once

#include <cstddef>
#include <vector>

namespace pluvia {

struct Image {
  int width = 0;
  int height = 0;
  int channels = 1;
  std::vector<float> values = {};  // size width * height * channels

  float& at(int x, int y, int c = 0) { return values[index(x, y, c)]; }
  float at(int x, int y, int c = 0) const { return values[index(x, y, c)]; }

 private:
  std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels) +
           static_cast<std::size_t>(c);
  }
};

inline Image make_image(int width, int height, int channels = 1) {
  const auto n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                 static_cast<std::size_t>(channels);
  return {width, height, channels, std::vector<float>(n, 0.0f)};
}

}  // namespace pluvia
