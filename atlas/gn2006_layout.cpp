#include "atlas/gn2006_layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

namespace pluvia {
namespace {

std::string picture_name(int view, const std::string& light, int oscillation) {
  return fmt::format("cv{}_{}osc{}.png", view, light, oscillation);
}

// Plain decimal notation: not every reader knows exponents.
std::string factor_text(double factor) {
  const double told = gn2006_told_factor(factor);
  if (told == 0) return "0.000000";
  const std::string scientific = fmt::format("{:.5e}", told);
  const int exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  return fmt::format("{:.{}f}", told, std::max(0, 5 - exponent));
}

// Each number followed by a blank, the last one too.
std::string row_text(const OscillationFactors& factors) {
  std::string text;
  for (const double factor : factors) text += factor_text(factor) + " ";
  return text + "\n";
}

struct Word {
  std::string_view text = {};
  std::string place = {};  // FILE:LINE:COL
};

struct Line {
  std::vector<Word> words = {};  // at least one
  std::string end = {};          // place behind the last
};

[[noreturn]] void throw_at(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + ": " + what);
}

Line words_of(const std::string& file, std::size_t number, std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  Line line;
  std::size_t at = text.find_first_not_of(blanks);
  while (at != std::string_view::npos) {
    const std::size_t end = std::min(text.find_first_of(blanks, at), text.size());
    line.words.push_back(
        {text.substr(at, end - at), fmt::format("{}:{}:{}", file, number, at + 1)});
    at = text.find_first_not_of(blanks, end);
    line.end = fmt::format("{}:{}:{}", file, number, end + 1);
  }
  return line;
}

std::vector<Line> lines_of(const std::string& file, const std::string& text) {
  std::vector<Line> lines;
  std::size_t start = 0;
  for (std::size_t number = 1; start < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    Line line = words_of(file, number, std::string_view(text).substr(start, end - start));
    if (!line.words.empty()) lines.push_back(std::move(line));
    start = end + 1;
  }
  return lines;
}

// The N of a word such as v-90; nothing where the word is another.
std::optional<int> labelled(const Word& word, std::string_view label) {
  if (!word.text.starts_with(label)) return std::nullopt;
  int number = 0;
  const char* const end = word.text.data() + word.text.size();
  const auto result = std::from_chars(word.text.data() + label.size(), end, number);
  if (result.ec != std::errc() || result.ptr != end) return std::nullopt;
  return number;
}

// The ten numbers from word `first` on, and nothing behind them.
OscillationFactors factors_of(const Line& line, std::size_t first) {
  OscillationFactors factors = {};
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (first + i >= line.words.size()) {
      throw_at(line.end,
               fmt::format("end of the line after {} factors; expected {}", i, factors.size()));
    }
    const Word& word = line.words[first + i];
    const char* const end = word.text.data() + word.text.size();
    const auto result = std::from_chars(word.text.data(), end, factors[i]);
    const bool number = result.ec == std::errc() && result.ptr == end;
    if (!number || !std::isfinite(factors[i]) || factors[i] < 0) {
      throw_at(word.place, fmt::format("\"{}\"; expected a factor >= 0", word.text));
    }
  }
  if (line.words.size() > first + factors.size()) {
    const Word& word = line.words[first + factors.size()];
    throw_at(word.place, fmt::format("\"{}\"; expected the end of the line after {} factors",
                                     word.text, factors.size()));
  }
  return factors;
}

int view_of(const Word& word) {
  const std::optional<int> view = labelled(word, "cv");
  if (!view || std::find(gn2006_views_deg.begin(), gn2006_views_deg.end(), *view) ==
                   gn2006_views_deg.end()) {
    throw_at(word.place, fmt::format("\"{}\"; expected cv0, cv20, cv40, cv60 or cv80", word.text));
  }
  return *view;
}

void refuse_second_word(const Line& line) {
  if (line.words.size() == 1) return;
  throw_at(line.words[1].place,
           fmt::format("\"{}\"; expected the end of the line", line.words[1].text));
}

std::size_t light_of(const Word& word, std::optional<int> elevation) {
  const std::optional<int> azimuth = labelled(word, "h");
  if (!azimuth) throw_at(word.place, fmt::format("\"{}\"; expected vN or hN", word.text));
  if (!elevation) throw_at(word.place, fmt::format("\"{}\"; expected vN before it", word.text));
  const auto lights = gn2006_light_directions();
  const auto at = std::find(lights.begin(), lights.end(), LightDirection{*elevation, *azimuth});
  if (at == lights.end()) {
    throw_at(word.place, fmt::format("\"{}\" of v{}; expected one of the layout's 74 lights",
                                     word.text, *elevation));
  }
  return static_cast<std::size_t>(at - lights.begin());
}

}  // namespace

std::string gn2006_env_picture(int size_px, int view_elevation_deg, int oscillation) {
  return fmt::format("env_light_database/size{}/{}", size_px,
                     picture_name(view_elevation_deg, "", oscillation));
}

std::string gn2006_point_picture(int size_px, int view_elevation_deg, const LightDirection& light,
                                 int oscillation) {
  const std::string name = fmt::format("v{}_h{}_", light.elevation_deg, light.azimuth_deg);
  return fmt::format("point_light_database/size{}/dcam{:02}/{}", size_px, view_elevation_deg,
                     picture_name(view_elevation_deg, name, oscillation));
}

std::string gn2006_env_factor_file() {
  return "env_light_database/txt/normalized_env_max.txt";
}

std::string gn2006_point_factor_file(int view_elevation_deg) {
  return fmt::format("point_light_database/txt/dcam{:02}_point_max.txt", view_elevation_deg);
}

double gn2006_told_factor(double factor) {
  return std::stod(fmt::format("{:.5e}", factor));
}

std::string gn2006_env_factor_text(const std::vector<ViewFactors>& views) {
  std::string text;
  for (const ViewFactors& view : views) {
    text += fmt::format("cv{}\n", view.view_elevation_deg) + row_text(view.env);
  }
  return text;
}

std::string gn2006_point_factor_text(const ViewFactors& view) {
  std::string text = fmt::format("cv{}\n", view.view_elevation_deg);
  const auto lights = gn2006_light_directions();
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (i == 0 || lights[i].elevation_deg != lights[i - 1].elevation_deg) {
      text += fmt::format("v{}\n", lights[i].elevation_deg);
    }
    text += fmt::format("h{} ", lights[i].azimuth_deg) + row_text(view.point[i]);
  }
  return text;
}

std::vector<ViewFactors> parse_gn2006_env_factors(const std::string& file,
                                                  const std::string& text) {
  std::vector<ViewFactors> views;
  const std::vector<Line> lines = lines_of(file, text);
  for (std::size_t i = 0; i < lines.size(); i += 2) {
    const Word& word = lines[i].words.front();
    const int view = view_of(word);
    refuse_second_word(lines[i]);
    if (!views.empty() && views.back().view_elevation_deg >= view) {
      throw_at(word.place, fmt::format("\"{}\" after cv{}; expected ascending views, each once",
                                       word.text, views.back().view_elevation_deg));
    }
    if (i + 1 == lines.size()) {
      throw_at(lines[i].end, fmt::format("end of the file; expected the factors of cv{}", view));
    }
    views.push_back({.view_elevation_deg = view, .env = factors_of(lines[i + 1], 0)});
  }
  if (views.empty()) throw_at(file + ":1:1", "an empty file; expected cv0 and its factors");
  return views;
}

std::vector<OscillationFactors> parse_gn2006_point_factors(const std::string& file,
                                                           const std::string& text) {
  const std::vector<Line> lines = lines_of(file, text);
  if (lines.empty()) throw_at(file + ":1:1", "an empty file; expected cvN, vN and hN lines");
  view_of(lines.front().words.front());
  const auto lights = gn2006_light_directions();
  std::vector<std::optional<OscillationFactors>> found(lights.size());
  std::optional<int> elevation;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const Word& word = lines[i].words.front();
    if (const std::optional<int> v = labelled(word, "v")) {
      elevation = v;
      refuse_second_word(lines[i]);
      continue;
    }
    auto& place = found[light_of(word, elevation)];
    if (place) throw_at(word.place, fmt::format("\"{}\" again; expected it once", word.text));
    place = factors_of(lines[i], 1);
  }
  std::vector<OscillationFactors> factors;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (!found[i]) {
      throw_at(lines.back().end, fmt::format("end of the file without h{} of v{}; expected all 74 "
                                             "lights",
                                             lights[i].azimuth_deg, lights[i].elevation_deg));
    }
    factors.push_back(*found[i]);
  }
  return factors;
}

}  // namespace pluvia
