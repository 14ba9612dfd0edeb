// What a frame of rain costs by drops, packets, lookup and lights, beside the path of 2010, as CSV:
// medians of frames of one run on one machine, so that its rows may be compared with each other and
// with nothing else. Beyond 1e5 drops one frame each.
//   rain_cost [--frames 3] [--most-drops 100000]
// Or by looks, at 720 x 480 under one lamp and a map, with the numbers of drops of which Wang et
// al. (MSR-TR-2006-102) give frame rates; the look stands where the lookup does:
//   rain_cost --looks MAP.exr [--masks DIR] [--frames 3]
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "realtime/rain_renderer.h"
#include "tests/bench/far_rain.h"
#include "tests/synthetic_atlas.h"
#include "validate/median.h"

namespace pluvia {
namespace {

struct CostFlags {
  int frames = 3;
  double most_drops = 1e5;
  std::string looks_under = {};  // a map
  std::string masks = {};        // of refraction, which is a look more
};

struct Cost {
  double wall_s = 0, cpu_s = 0, frame_s = 0;
  long streaks = 0, looked_at = 0;
  std::size_t bytes = 0;  // beside the atlas
};

bool of_atlas(const std::string& resource) {
  return resource == "atlas: sums" || resource == "thin streaks: profiles";
}

Cost measure(const Scene& scene, const StreakAtlas& atlas, const RenderOptions& options,
             int frames) {
  RainRenderer renderer(scene, atlas, options);
  renderer.render(0);  // compiles, and makes the records' room
  Cost cost;
  std::vector<double> wall, cpu, all;
  for (int k = 0; k < frames; ++k) {
    const Frame frame = renderer.render(0.1 * (k + 1));
    double rain_wall_s = 0, rain_cpu_s = 0, sum = 0;
    for (const PassCost& pass : frame.costs) {
      sum += pass.wall_s;
      if (pass.pass != "rain" && pass.pass != "billboards") continue;
      rain_wall_s += pass.wall_s;
      rain_cpu_s += pass.cpu_s;
    }
    wall.push_back(rain_wall_s);
    cpu.push_back(rain_cpu_s);
    all.push_back(sum);
    cost.streaks = frame.streaks_in_view;
    cost.looked_at = frame.packets.drops_looked_at;
  }
  cost.wall_s = median(wall), cost.cpu_s = median(cpu), cost.frame_s = median(all);
  for (const PlannedPass& pass : renderer.plan().passes) {
    if (pass.name != "rain") continue;
    for (const PlannedResource& resource : pass.resources)
      cost.bytes += of_atlas(resource.name) ? 0 : resource.bytes;
  }
  return cost;
}

struct Row {
  double drops = 0;
  std::string path = {};  // packets of the streaks, or the path of 2010
  std::string lookup = {};
  int lights = 0;
  RenderOptions options = {};
};

// All of them up to 1e5 drops; of more, one lamp and six, and two packet schemes.
std::vector<Row> all_rows(double most_drops) {
  std::vector<Row> rows;
  for (double drops = 1e3; drops <= most_drops; drops *= 10) {
    for (int lights = 1; lights <= 6; ++lights) {
      if (drops > 1e5 && lights % 5 != 1) continue;
      rows.push_back({drops,
                      "2010",
                      lookup_name(LookupMode::view_linear),
                      lights,
                      {.path = RainPath::billboards_2010,
                       .packets = {.selection = PacketSelection::rectangle}}});
      for (const auto lookup :
           {LookupMode::nearest, LookupMode::view_linear, LookupMode::trilinear}) {
        for (const auto scheme : {PacketScheme::automatic, PacketScheme::world, PacketScheme::tree,
                                  PacketScheme::grid}) {
          if (drops > 1e5 && scheme != PacketScheme::automatic && scheme != PacketScheme::world)
            continue;
          rows.push_back({drops,
                          packet_scheme_name(scheme),
                          lookup_name(lookup),
                          lights,
                          {.packets = {.scheme = scheme}, .lookup = lookup}});
        }
      }
    }
  }
  return rows;
}

std::vector<Row> look_rows(double drops) {
  const std::pair<const char*, RenderOptions> looks[] = {
      {"billboards of 2010 nearest",
       {.path = RainPath::billboards_2010,
        .packets = {.selection = PacketSelection::rectangle},
        .lookup = LookupMode::nearest}},
      {"billboards of 2010 view-linear",
       {.path = RainPath::billboards_2010, .packets = {.selection = PacketSelection::rectangle}}},
      {"traced nearest", {.lookup = LookupMode::nearest}},
      {"traced view-linear", {}},
      {"traced trilinear", {.lookup = LookupMode::trilinear}},
      {"traced view-linear sky's mean", {.sky_degree = 0}},
      {"traced view-linear quads", {.widest_splat_px = 0}},
      {"sphere", {.look = StreakLook::sphere}},
      {"sphere-published", {.look = StreakLook::sphere_published}},
      {"white", {.look = StreakLook::white}}};
  std::vector<Row> rows;
  for (const auto& [name, options] : looks) rows.push_back({drops, "automatic", name, 1, options});
  return rows;
}

// By masks: thin streaks walked, then all as quads, whose pixels take so many samples.
std::vector<Row> refraction_rows(double drops) {
  std::vector<Row> rows = {{drops, "automatic", "refraction", 1, {.look = StreakLook::refraction}}};
  for (const int samples : {1, 5, 10, 20, 50}) {
    rows.push_back(
        {drops,
         "automatic",
         fmt::format("refraction quads {}", samples),
         1,
         {.widest_splat_px = 0, .look = StreakLook::refraction, .persistence_samples = samples}});
  }
  return rows;
}

std::vector<Row> published_rows(bool masks) {
  std::vector<Row> rows;
  for (const double drops : {1e4, 2e4, 4e4, 8e4}) {
    for (const Row& row : look_rows(drops)) rows.push_back(row);
    if (!masks) continue;
    for (const Row& row : refraction_rows(drops)) rows.push_back(row);
  }
  return rows;
}

// As published: 720 x 480.
Scene under_map(Scene scene, const std::string& map) {
  scene.camera.width_px = 720;
  scene.camera.height_px = 480;
  scene.environment = {.map_file = map};
  return scene;
}

void run(const CostFlags& flags) {
  const bool looks = !flags.looks_under.empty();
  StreakAtlas atlas = synthetic_atlas({.cell_width_px = 16, .levels = 5});
  if (looks) add_harmonics(atlas, 3);
  fmt::print(
      "drops,packets,lookup,lights,streaks,looked_at,rain_ms,cpu_ms,frame_ms,"
      "mb_beside_the_atlas\n");
  if (!flags.masks.empty()) atlas.masks = read_refraction_masks(flags.masks);
  const std::vector<Row> rows =
      looks ? published_rows(!flags.masks.empty()) : all_rows(flags.most_drops);
  for (const Row& row : rows) {
    const int frames = row.drops > 1e5 ? 1 : flags.frames;
    Scene scene = far_rain(row.drops, row.lights);
    if (looks) scene = under_map(scene, flags.looks_under);
    const Cost cost = measure(scene, atlas, row.options, frames);
    fmt::print("{:.0f},{},{},{},{},{},{:.2f},{:.2f},{:.2f},{:.1f}\n", row.drops, row.path,
               row.lookup, row.lights, cost.streaks, cost.looked_at, 1e3 * cost.wall_s,
               1e3 * cost.cpu_s, 1e3 * cost.frame_s, static_cast<double>(cost.bytes) / 1e6);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace pluvia

int main(int argc, char** argv) {
  CLI::App app("What a frame of rain costs", "rain_cost");
  pluvia::CostFlags flags;
  app.add_option("--frames", flags.frames, "of which the median is taken")
      ->check(CLI::Range(1, 99));
  app.add_option("--most-drops", flags.most_drops, "1e3 .. 1e6")->check(CLI::Range(1e3, 1e6));
  CLI::Option* const looks =
      app.add_option("--looks", flags.looks_under, "looks under this map instead");
  app.add_option("--masks", flags.masks, "of refraction, a look more")->needs(looks);
  CLI11_PARSE(app, argc, argv);
  try {
    pluvia::run(flags);
  } catch (const std::exception& error) {
    fmt::print(stderr, "rain_cost: {}\n", error.what());
    return 1;
  }
  return 0;
}
