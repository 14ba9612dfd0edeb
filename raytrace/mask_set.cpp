#include "raytrace/mask_set.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "atlas/flag_values.h"
#include "raytrace/process_time.h"
#include "raytrace/refraction_mask.h"

namespace pluvia {
namespace {

// Between two masks directions go straight: of a sine sampled so often cos(pi / 4) is left midway.
constexpr double phases_per_period = 4;

void check_count(std::string_view name, int value, int least, int most) {
  if (value < least || value > most)
    throw std::invalid_argument(
        fmt::format("{} = {}; expected {} .. {}", name, value, least, most));
}

void check_options(const Preset& preset, const MaskSetOptions& options) {
  check_count("size_px", options.size_px, 4, 512);
  check_count("max_order", options.max_order, 0, 15);
  check_count("phases", options.phases, 1, 1024);
  check_count("instants", options.instants, 1, 4096);
  check_count("angles", options.angles, 16, 1024);
  if (options.view_elevations_deg.empty())
    throw std::invalid_argument("no view elevation; expected at least one");
  for (const int view : options.view_elevations_deg)
    check_count("view elevation in degrees", view, -90, 90);
  if (preset.cone_half_angle_deg == 0)
    throw std::invalid_argument(
        "light.cone_half_angle_deg = 0; expected a cone: no line of sight meets a point");
}

// The time that a streak picture of the drop shows (raytrace/streak_placement.h).
double picture_s(const Preset& preset, int diameter_um) {
  const SizeRecord size = size_of(preset, diameter_um);
  return size.span_s * std::pow(diameter_um * 0.5e-6 / size.mean_radius_m, 1.5);
}

struct MaskSet {
  const Preset& preset;
  const MaskSetOptions& options;
  MaskSetCost& cost;
  RefractionMasks masks = {};

  void add_mask(const DropInstant& drop, const View& view, std::size_t index) {
    const RefractionMask mask = trace_round_mask(
        drop, view, options.size_px,
        {.refractive_index = masks.refractive_index, .max_order = options.max_order});
    cost.astray = std::max(cost.astray, mask.astray);
    const int first = static_cast<int>(index) * options.size_px;
    for (int order = 0; order <= options.max_order; ++order) {
      for (int row = 0; row < options.size_px; ++row) {
        for (int column = 0; column < options.size_px; ++column) {
          const MaskExit& exit = mask.exit(order, column, row);
          for (int c = 0; c < 3; ++c)
            masks.exits.at(order * options.size_px + column, first + row, c) =
                static_cast<float>(exit.direction[c]);
          masks.exits.at(order * options.size_px + column, first + row, 3) =
              static_cast<float>(exit.weight);
        }
      }
    }
  }

  void add_outlines(const DropShape& shape, double duration_s, const View& view, int first) {
    for (int k = 0; k < options.instants; ++k) {
      const DropInstant drop = drop_at(shape, (k + 0.5) / options.instants * duration_s);
      const auto outline = outline_from_origin_m(drop, view, options.angles);
      for (int a = 0; a < options.angles; ++a)
        masks.outlines.at(a, first + k) =
            static_cast<float>(outline[static_cast<std::size_t>(a)] / shape.mean_radius_m);
    }
  }

  // One drop from one side.
  void add_view(const DropShape& shape, double duration_s, MaskPlace place) {
    const View view = view_from_elevation(masks.view_elevations_deg[place.view]);
    const std::size_t first = mask_index(masks, place);
    add_outlines(shape, duration_s, view,
                 static_cast<int>(first) / options.phases * options.instants);
    for (int k = 0; k < options.phases; ++k) {
      const double time = options.phases > 1 ? static_cast<double>(k) / (options.phases - 1) : 0.5;
      add_mask(drop_at(shape, time * duration_s), view, first + static_cast<std::size_t>(k));
    }
  }
};

std::vector<int> drops_of(const Preset& preset, const MaskSetOptions& options) {
  return options.diameters_um.empty() ? diameters_of(preset) : options.diameters_um;
}

RefractionMasks empty_masks(const Preset& preset, const MaskSetOptions& options) {
  RefractionMasks masks = {
      .size_px = options.size_px,
      .orders = options.max_order + 1,
      .phases = options.phases,
      .instants = options.instants,
      .refractive_index = mean_refractive_index(preset),
      .cone_half_angle_rad = preset.cone_half_angle_deg * std::numbers::pi / 180,
      .diameters_um = drops_of(preset, options),
      .view_elevations_deg = options.view_elevations_deg};
  for (const int diameter_um : masks.diameters_um)
    masks.durations_s.push_back(picture_s(preset, diameter_um));
  masks.oscillations = preset.oscillations;
  std::sort(masks.oscillations.begin(), masks.oscillations.end());
  if (mask_count(masks) > most_masks)
    throw std::invalid_argument(
        fmt::format("{} masks; expected at most {}", mask_count(masks), most_masks));
  const auto count = static_cast<int>(mask_count(masks));
  masks.exits = make_image(masks.orders * masks.size_px, count * masks.size_px, 4);
  masks.outlines = make_image(options.angles, count / masks.phases * masks.instants, 1);
  return masks;
}

}  // namespace

RefractionMasks trace_mask_set(const Preset& preset, const MaskSetOptions& options,
                               MaskSetCost& cost, const std::function<void(double)>& progress) {
  check_options(preset, options);
  const double begun_s = process_cpu_s();
  MaskSet set = {preset, options, cost, empty_masks(preset, options)};
  const RefractionMasks& masks = set.masks;
  for (std::size_t d = 0; d < masks.diameters_um.size(); ++d) {
    for (std::size_t o = 0; o < masks.oscillations.size(); ++o) {
      const DropShape shape =
          drop_shape(preset, masks.oscillations[o], masks.diameters_um[d] * 0.5e-6);
      for (std::size_t v = 0; v < masks.view_elevations_deg.size(); ++v)
        set.add_view(shape, masks.durations_s[d], {d, o, v, 0});
      const auto done = static_cast<double>(d * masks.oscillations.size() + o + 1);
      const auto all = static_cast<double>(masks.diameters_um.size() * masks.oscillations.size());
      if (progress) progress(done / all);
    }
  }
  cost.cpu_s = process_cpu_s() - begun_s;
  return set.masks;
}

CLI::App* add_masks(CLI::App& app, MasksFlags& flags) {
  CLI::App* command =
      app.add_subcommand("masks", "trace where drops refract light to, for --look refraction");
  command->add_option("preset", flags.preset, "whose drops, TOML")->required();
  command->add_option("--out", flags.out, "folder of the masks")->required();
  command->add_option("--diameters-mm", flags.diameters_mm, "of the drops; default: the preset's")
      ->check(finite_range(0.1, 7));
  command->add_option("--views", flags.options.view_elevations_deg, "elevations in degrees")
      ->check(CLI::Range(-90, 90))
      ->capture_default_str();
  command->add_option("--size-px", flags.options.size_px, "of a mask")
      ->check(CLI::Range(4, 512))
      ->capture_default_str();
  command->add_option("--max-order", flags.options.max_order, "segments inside the drop, at most")
      ->check(CLI::Range(0, 15))
      ->capture_default_str();
  command
      ->add_option(
          "--phases", flags.options.phases,
          "masks of a drop, evenly over the time that its streak picture shows; 1: one for all")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->footer("example: pluvia masks data/presets/preview.toml --out masks");
  return command;
}

namespace {

// A single phase is one mask for all outlines, as published.
void refuse_few_phases(const Preset& preset, const MaskSetOptions& options) {
  if (options.phases == 1) return;
  for (const int diameter_um : drops_of(preset, options)) {
    const double duration_s = picture_s(preset, diameter_um);
    for (const int oscillation : preset.oscillations) {
      const double periods =
          fastest_mode_periods(drop_shape(preset, oscillation, diameter_um * 0.5e-6), duration_s);
      const int least = static_cast<int>(std::ceil(phases_per_period * periods)) + 1;
      if (options.phases >= least) continue;
      throw std::runtime_error(fmt::format(
          "--phases {}: a drop of {} mm goes through {:.1f} periods of its fastest mode in its "
          "{:.3g} "
          "s; expected 1, or at least {}, {} for each",
          options.phases, diameter_um / 1000.0, periods, duration_s, least, phases_per_period));
    }
  }
}

// A drop or light that no mask can be traced of lies in the preset, or in the options with it.
RefractionMasks traced(const MasksFlags& flags, const Preset& preset, const MaskSetOptions& options,
                       MaskSetCost& cost,
                       const std::function<void(const std::string&, double)>& progress) {
  try {
    refuse_few_phases(preset, options);
    return trace_mask_set(preset, options, cost, [&](double share) {
      if (progress) progress("refraction masks", share);
    });
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(flags.preset + ": " + error.what());
  }
}

}  // namespace

std::string write_masks(const MasksFlags& flags,
                        const std::function<void(const std::string&, double)>& progress) {
  const Preset preset = read_preset(flags.preset);
  MaskSetOptions options = flags.options;
  const auto ascending = [](std::vector<int>& values) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  };
  for (const double mm : flags.diameters_mm)
    options.diameters_um.push_back(static_cast<int>(std::lround(1000 * mm)));
  ascending(options.diameters_um);
  ascending(options.view_elevations_deg);
  MaskSetCost cost;
  const RefractionMasks masks = traced(flags, preset, options, cost, progress);
  write_refraction_masks(flags.out, masks);
  return fmt::format(
      "{}: {} masks of {} x {} and {} orders in {:.1f} CPU s, {:.1f} MB, {:.4f} of "
      "a pixel's light astray at most\n",
      flags.out, mask_count(masks), masks.size_px, masks.size_px, masks.orders, cost.cpu_s,
      static_cast<double>(masks.exits.values.size()) * 4e-6, cost.astray);
}

}  // namespace pluvia
