#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "validate/report_parts.h"

namespace pluvia {
namespace {

// Middle tones, legible on white and on black.
constexpr const char* colors[] = {"#2a7fba", "#d1603d", "#3f9b5b", "#a05fb4",
                                  "#b8860b", "#5f6b7a", "#c2457e", "#2f9a9a"};

std::string about(const Plot& plot, const std::string& message) {
  return fmt::format("plot \"{}\": {}", plot.title, message);
}

// A gnuplot string: nothing is special between single quotes but the quote itself, which is
// doubled. A line end would end the command.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + "'";
}

bool drawable(const Plot& plot, const Curve& curve, std::size_t i) {
  return std::isfinite(curve.x[i]) && std::isfinite(curve.y[i]) &&
         (!plot.log_x || curve.x[i] > 0) && (!plot.log_y || curve.y[i] > 0);
}

void refuse_unequal(const Plot& plot, const Curve& curve) {
  const std::size_t n = curve.x.size();
  const auto fits = [&](const std::vector<double>& bars) {
    return bars.empty() || bars.size() == n;
  };
  if (curve.y.size() == n && fits(curve.y_error) && fits(curve.x_low) &&
      curve.x_low.size() == curve.x_high.size()) {
    return;
  }
  throw std::runtime_error(about(
      plot,
      fmt::format("curve \"{}\" has {} x, {} y, {} y_error, {} x_low, {} x_high; expected equal "
                  "lengths",
                  curve.label, n, curve.y.size(), curve.y_error.size(), curve.x_low.size(),
                  curve.x_high.size())));
}

// "x y y_error x_low x_high"; a bar that is missing or not finite has no length.
std::string data_line(const Curve& curve, std::size_t i) {
  const auto bar = [&](const std::vector<double>& values, double none) {
    return !values.empty() && std::isfinite(values[i]) ? values[i] : none;
  };
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", curve.x[i], curve.y[i],
                     bar(curve.y_error, 0), bar(curve.x_low, curve.x[i]),
                     bar(curve.x_high, curve.x[i]));
}

// The data blocks $d0, $d1, ..; returns how many points there are to draw.
long append_data(const Plot& plot, std::string& script) {
  long points = 0;
  for (std::size_t k = 0; k < plot.curves.size(); ++k) {
    const Curve& curve = plot.curves[k];
    refuse_unequal(plot, curve);
    script += fmt::format("$d{} << END\n", k);
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!drawable(plot, curve, i)) continue;
      script += data_line(curve, i);
      ++points;
    }
    script += "END\n";
  }
  return points;
}

// What gnuplot does with a data block.
std::string drawn_as(const Curve& curve) {
  if (curve.style == CurveStyle::line) return "using 1:2 with lines lw 4";
  if (curve.style == CurveStyle::rings) return "using 1:2 with points pt 6 ps 1.6 lw 3";
  const bool x_bars = !curve.x_low.empty(), bars = x_bars || !curve.y_error.empty();
  const std::string columns = x_bars ? "1:2:4:5:($2-$3):($2+$3)" : bars ? "1:2:3" : "1:2";
  const std::string kind = x_bars ? "xyerror" : bars ? "yerror" : "";
  const bool joined = curve.style == CurveStyle::joined;
  const std::string form =
      kind.empty() ? (joined ? "linespoints" : "points") : kind + (joined ? "lines" : "bars");
  return fmt::format("using {} with {} pt 7 ps 0.5 lw 2", columns, form);
}

constexpr const char* head =
    "set encoding utf8\n"
    "set grid\n"
    "set key outside top left horizontal Left reverse samplen 2 maxcols 3\n";

// Rows of the key take their height from outside the plot. Long labels stand one in a row.
std::size_t key_rows(const Plot& plot) {
  const bool wide = std::any_of(plot.curves.begin(), plot.curves.end(),
                                [](const Curve& curve) { return curve.label.size() > 18; });
  return wide ? plot.curves.size() : (plot.curves.size() + 1) / 2;
}

// Empty when there is no point to draw.
std::string plot_script(const Plot& plot) {
  std::string script = head;
  script +=
      fmt::format("set terminal svg size 560,{} dynamic noenhanced font 'inherit,14' rounded\n",
                  380 + 22 * (std::max<std::size_t>(key_rows(plot), 2) - 2));
  if (plot.log_x) script += "set logscale x\nset format x '%g'\n";
  if (plot.log_y) script += "set logscale y\nset format y '%g'\n";
  script += "set xlabel " + quoted(plot.x_label) + "\nset ylabel " + quoted(plot.y_label) + "\n";
  if (append_data(plot, script) == 0) return "";
  const char* separator = "plot ";
  for (std::size_t k = 0; k < plot.curves.size(); ++k) {
    const Curve& curve = plot.curves[k];
    const bool mark = curve.style == CurveStyle::line || curve.style == CurveStyle::rings;
    script += fmt::format("{}$d{} {} lc rgb '{}' title {}", separator, k, drawn_as(curve),
                          mark ? "#808080" : colors[k % std::size(colors)], quoted(curve.label));
    separator = ", ";
  }
  return script + "\n";
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

File scratch_file() {
  File file(std::tmpfile(), &std::fclose);
  if (!file) throw std::runtime_error("temporary file: cannot create; expected a writable /tmp");
  return file;
}

std::string contents(std::FILE* file) {
  std::string text;
  char buffer[4096];
  std::rewind(file);
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, file)) text.append(buffer, n);
  return text;
}

struct Run {
  int status = 0;  // of waitpid; -1: could not be started
  std::string output = {};
  std::string messages = {};
};

// Runs gnuplot without a shell: script in, picture and messages out, all through unnamed files, so
// that neither side can wait for the other.
Run run_gnuplot(const std::string& script) {
  const File in = scratch_file(), out = scratch_file(), err = scratch_file();
  if (std::fwrite(script.data(), 1, script.size(), in.get()) != script.size() ||
      std::fflush(in.get()) != 0) {
    throw std::runtime_error("temporary file: cannot write; expected room in /tmp");
  }
  std::rewind(in.get());
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
  std::string words[] = {"gnuplot", "-"};
  char* arguments[] = {words[0].data(), words[1].data(), nullptr};
  pid_t child = 0;
  const int spawned = posix_spawnp(&child, words[0].c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (spawned != 0) return {.status = -1};
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return {status, contents(out.get()), contents(err.get())};
}

}  // namespace

PlotDrawing draw_plot(const Plot& plot) {
  const std::string script = plot_script(plot);
  if (script.empty()) return {"", about(plot, "no finite point to draw")};
  Run run = run_gnuplot(script);
  if (run.status == -1) return {"", about(plot, "gnuplot is not installed (package gnuplot-nox)")};
  const std::size_t begin = run.output.find("<svg");
  if (run.status != 0 || begin == std::string::npos) {
    return {"", about(plot, "gnuplot refuses it: " + run.messages)};
  }
  // The <title> holds only the program's name, which viewers would show as a tooltip.
  std::string svg = run.output.substr(begin);
  const std::size_t title = svg.find("<title>"), title_end = svg.find("</title>");
  if (title_end != std::string::npos) svg.erase(title, title_end + 8 - title);
  return {svg, ""};
}

}  // namespace pluvia
