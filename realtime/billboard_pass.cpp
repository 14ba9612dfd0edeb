#include "realtime/billboard_pass.h"

#include <stdexcept>

#include <fmt/format.h>

namespace pluvia {
namespace {

// All levels of one kind of picture, of every layer.
GlTexture upload_pictures(const StreakAtlas& atlas, std::vector<Image> AtlasLayer::*kind) {
  const std::vector<Image>& first = atlas.layers.front().*kind;
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (first.empty() || first[0].width > largest || first[0].height > largest)
    throw std::runtime_error(fmt::format(
        "billboards: atlas pictures of {} x {} texels; expected 1 x 1 to {} x {}",
        first.empty() ? 0 : first[0].width, first.empty() ? 0 : first[0].height, largest, largest));
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
  GlTexture texture(id);
  // Rows are padded to a multiple of the coarsest texel, so that each level is half of the last.
  const int step = 1 << (atlas.levels - 1);
  const int height = (first[0].height + step - 1) / step * step;
  const auto layers = static_cast<GLsizei>(atlas.layers.size());
  glTextureStorage3D(id, atlas.levels, GL_R16F, first[0].width, height, layers);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int layer = 0; layer < layers; ++layer) {
    const std::vector<Image>& levels = atlas.layers[static_cast<std::size_t>(layer)].*kind;
    for (int level = 0; level < atlas.levels; ++level) {
      const Image& image = levels.at(static_cast<std::size_t>(level));
      glTextureSubImage3D(id, level, 0, 0, layer, image.width, image.height, 1, GL_RED, GL_FLOAT,
                          image.values.data());
    }
  }
  return texture;
}

}  // namespace

BillboardPass make_billboard_pass(const Scene& scene, const StreakAtlas& atlas, bool environment) {
  if (scene.lights.size() > most_billboard_lights)
    throw std::runtime_error(fmt::format("billboards: {} lights; expected at most {}",
                                         scene.lights.size(), most_billboard_lights));
  BillboardPass pass;
  pass.point = upload_pictures(atlas, &AtlasLayer::point);
  if (environment) pass.environment = upload_pictures(atlas, &AtlasLayer::env);
  pass.coverage = upload_pictures(atlas, &AtlasLayer::coverage);
  pass.no_vertices = make_vertex_array();
  return pass;
}

void plan_billboards(const BillboardPass& pass, PlannedPass& plan) {
  if (pass.empty()) return;
  plan.add(pass.program);
  plan.add("billboards: point light", pass.point);
  plan.add("billboards: environment", pass.environment);
  plan.add("billboards: coverage", pass.coverage);
}

}  // namespace pluvia
