#include "validate/rain_strokes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "validate/median.h"
#include "validate/picture_planes.h"

namespace pluvia {
namespace {

constexpr int margin_px = 2;
constexpr double slenderness = 4;  // least length over width
constexpr double border_px = 2;    // a stroke that comes so near to the border may be cut

struct Upright {  // a matte whose fall is vertical
  Plane plane = {};
  double left_px = 0, top_px = 0;  // of its corner from the frame's, before turning back
  double lean_rad = 0;
  int frame_width = 0, frame_height = 0;
};

struct Point {
  double x = 0, y = 0;
};

// Where in the frame a point of the upright picture lies: turned back about the frame's middle.
Point in_frame(const Upright& upright, const Point& point) {
  const double middle_x = upright.frame_width / 2.0, middle_y = upright.frame_height / 2.0;
  const double x = point.x + upright.left_px - middle_x, y = point.y + upright.top_px - middle_y;
  const double c = std::cos(upright.lean_rad), s = std::sin(upright.lean_rad);
  return {middle_x + x * c + y * s, middle_y - x * s + y * c};
}

Plane plane_of_buffer(const OIIO::ImageBuf& buffer) {
  const OIIO::ROI roi = buffer.roi();
  std::vector<float> values(static_cast<std::size_t>(roi.width() * roi.height()));
  if (buffer.has_error() || !buffer.get_pixels(roi, OIIO::TypeDesc::FLOAT, values.data()))
    throw std::runtime_error("rain_strokes: " + buffer.geterror());
  using Floats = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Floats>(values.data(), roi.height(), roi.width()).cast<double>();
}

// The least (factor 1) or largest (-1) of the values within reach above and below. OpenImageIO 2.4
// has erode and dilate, but its lines of one pixel's width lie beside the pixel.
Plane least_along(const Plane& plane, Eigen::Index reach, double factor) {
  Plane least = factor * plane;
  for (Eigen::Index step = 1; step <= std::min(reach, plane.rows() - 1); ++step) {
    const Eigen::Index rows = plane.rows() - step;
    least.topRows(rows) = least.topRows(rows).min(factor * plane.bottomRows(rows));
    least.bottomRows(rows) = least.bottomRows(rows).min(factor * plane.topRows(rows));
  }
  return factor * least;
}

// OpenImageIO turns clockwise: a lower end at the right goes down. Its triangle filter has no
// negative lobes, so nothing leaves 0 .. 1.
Upright upright_of(Image matte, double lean_deg, const StrokeSettings& settings) {
  const OIIO::ImageSpec spec(matte.width, matte.height, 1, OIIO::TypeDesc::FLOAT);
  const OIIO::ImageBuf source(spec, matte.values.data());
  const double lean = lean_deg * std::numbers::pi / 180;
  const OIIO::ImageBuf turned =
      OIIO::ImageBufAlgo::rotate(source, static_cast<float>(lean), "triangle", 2, true);
  const Eigen::Index line = settings.opening_px / 2;
  const Plane opened = least_along(least_along(plane_of_buffer(turned), line, 1), line, -1);
  const int reach = static_cast<int>(std::ceil(3 * settings.blur_px));
  const Kernel one = Kernel::Ones(1);
  const Kernel down = settings.blur_px > 0 ? unit_sum(gaussian(reach, settings.blur_px)) : one;
  return {.plane = filtered(opened, one, down),
          .left_px = static_cast<double>(turned.roi().xbegin),
          .top_px = static_cast<double>(turned.roi().ybegin),
          .lean_rad = lean,
          .frame_width = matte.width,
          .frame_height = matte.height};
}

using Labels = Eigen::Array<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Pixels = std::vector<std::pair<Eigen::Index, Eigen::Index>>;  // row, column

// All pixels that hang together with the first, with their eight neighbours each; they are
// labelled.
Pixels piece_at(Eigen::Index row, Eigen::Index column, const Plane& plane, double least, int label,
                Labels& labels) {
  Pixels piece = {{row, column}};
  labels(row, column) = label;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const auto [y0, x0] = piece[i];
    for (Eigen::Index y = std::max<Eigen::Index>(y0 - 1, 0);
         y <= std::min(y0 + 1, plane.rows() - 1); ++y) {
      for (Eigen::Index x = std::max<Eigen::Index>(x0 - 1, 0);
           x <= std::min(x0 + 1, plane.cols() - 1); ++x) {
        if (labels(y, x) != 0 || plane(y, x) < least) continue;
        labels(y, x) = label;
        piece.emplace_back(y, x);
      }
    }
  }
  std::sort(piece.begin(), piece.end());
  return piece;
}

// Every row one run that rises and falls once: no value is higher than one between it and the
// largest before by a quarter of that. Less is noise.
bool is_single(const Pixels& sorted, const Plane& plane) {
  double largest = 0, least = 0;  // of the row so far; since its largest
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto [y, x] = sorted[i];
    const bool same_row = i > 0 && y == sorted[i - 1].first;
    if (same_row && x != sorted[i - 1].second + 1) return false;
    if (!same_row) largest = least = plane(y, x);
    least = std::min(least, plane(y, x));
    if (least < largest && plane(y, x) - least > largest / 4) return false;
    if (plane(y, x) >= largest) largest = least = plane(y, x);
  }
  return true;
}

bool touches_border(const Pixels& piece, const Upright& upright) {
  return std::any_of(piece.begin(), piece.end(), [&](const auto& pixel) {
    const Point at = in_frame(
        upright, {static_cast<double>(pixel.second) + 0.5, static_cast<double>(pixel.first) + 0.5});
    return at.x < border_px || at.y < border_px || at.x > upright.frame_width - border_px ||
           at.y > upright.frame_height - border_px;
  });
}

struct Box {
  Eigen::Index top = 0, left = 0, rows = 0, columns = 0;
};

// Around the piece, with its margin, as far as the picture goes.
Box box_of(const Pixels& piece, const Plane& plane) {
  const auto [low, high] = std::minmax_element(
      piece.begin(), piece.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto from = [](Eigen::Index at) { return std::max<Eigen::Index>(at - margin_px, 0); };
  const Eigen::Index top = from(piece.front().first), left = from(low->second);
  const auto bottom = std::min(piece.back().first + margin_px + 1, plane.rows());
  const auto right = std::min(high->second + margin_px + 1, plane.cols());
  return {top, left, bottom - top, right - left};
}

Point middle_of(const Plane& stroke) {
  const double sum = stroke.sum();
  const auto places = [](Eigen::Index n) {
    return Eigen::ArrayXd::LinSpaced(n, 0.5, static_cast<double>(n) - 0.5);
  };
  return {(stroke.colwise().sum().transpose() * places(stroke.cols())).sum() / sum,
          (stroke.rowwise().sum() * places(stroke.rows())).sum() / sum};
}

RainStroke measured(const Plane& stroke, const Box& box, const Upright& upright, int frame) {
  const Eigen::ArrayXd largest = stroke.rowwise().maxCoeff();
  const auto bright = (largest >= largest.maxCoeff() / 2).cast<double>();
  const Point middle = middle_of(stroke);
  const Point place = in_frame(
      upright, {middle.x + static_cast<double>(box.left), middle.y + static_cast<double>(box.top)});
  return {.matte = image_of(stroke),
          .frame = frame,
          .x_px = place.x,
          .y_px = place.y,
          .width_px = stroke.sum() / largest.sum(),
          .length_px = bright.sum(),
          .brightness = (bright * largest).sum() / bright.sum()};
}

// None where the piece is no single stroke.
std::optional<RainStroke> stroke_of(const Pixels& piece, const Labels& labels,
                                    const Upright& upright, int frame) {
  if (!is_single(piece, upright.plane) || touches_border(piece, upright)) return std::nullopt;
  const Box box = box_of(piece, upright.plane);
  const int label = labels(piece.front().first, piece.front().second);
  const auto own = labels.block(box.top, box.left, box.rows, box.columns);
  const Plane stroke = (own == 0 || own == label)
                           .select(upright.plane.block(box.top, box.left, box.rows, box.columns),
                                   Plane::Zero(box.rows, box.columns));
  const RainStroke result = measured(stroke, box, upright, frame);
  if (result.length_px < slenderness * result.width_px) return std::nullopt;
  return result;
}

std::vector<RainStroke> strokes_of(const Upright& upright, double least, int frame) {
  Labels labels = Labels::Zero(upright.plane.rows(), upright.plane.cols());
  std::vector<Pixels> pieces;
  for (Eigen::Index y = 0; y < labels.rows(); ++y) {
    for (Eigen::Index x = 0; x < labels.cols(); ++x) {
      if (labels(y, x) != 0 || upright.plane(y, x) < least) continue;
      const int label = static_cast<int>(pieces.size()) + 1;
      pieces.push_back(piece_at(y, x, upright.plane, least, label, labels));
    }
  }
  std::vector<RainStroke> strokes;
  for (const Pixels& piece : pieces) {
    if (auto stroke = stroke_of(piece, labels, upright, frame)) strokes.push_back(*stroke);
  }
  return strokes;
}

// That one pixel in a thousand exceeds.
double strongest_matte(const std::vector<Image>& mattes) {
  std::vector<float> values;
  for (const Image& matte : mattes)
    values.insert(values.end(), matte.values.begin(), matte.values.end());
  return values.empty() ? 0 : static_cast<double>(exceeded_by_a_thousandth(std::move(values)));
}

void check_settings(const StrokeSettings& settings) {
  const bool fits = settings.opening_px >= 1 && settings.opening_px % 2 == 1 &&
                    settings.blur_px >= 0 && settings.blur_px <= 100 && settings.least_share > 0 &&
                    settings.least_share <= 1;
  if (fits) return;
  throw std::runtime_error(fmt::format(
      "rain_strokes: opening_px = {}, blur_px = {}, least_share = {}; expected an odd number >= 1, "
      "0 .. 100 and a number above 0, at most 1",
      settings.opening_px, settings.blur_px, settings.least_share));
}

}  // namespace

std::vector<RainStroke> rain_strokes(const std::vector<Image>& mattes, double lean_deg,
                                     const StrokeSettings& settings) {
  check_settings(settings);
  std::vector<std::vector<RainStroke>> frames(mattes.size());
  const double least = settings.least_share * strongest_matte(mattes);
  if (least == 0) return {};
  tbb::parallel_for(std::size_t{0}, mattes.size(), [&](std::size_t k) {
    frames[k] = strokes_of(upright_of(mattes[k], lean_deg, settings), least, static_cast<int>(k));
  });
  std::vector<RainStroke> strokes;
  for (const auto& frame : frames) strokes.insert(strokes.end(), frame.begin(), frame.end());
  return strokes;
}

}  // namespace pluvia
