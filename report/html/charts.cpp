// The charts of html.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html/html.h"

namespace keypose::report {
namespace {

constexpr double kHeight = 270, kLeft = 66, kRight = 14, kTop = 50, kBottom = 40;
constexpr double kNarrow = 540, kWide = 1100;  // half of the page's width, and all of it

/// Axis with round ticks that covers [low, high].
struct Axis {
  double low, high, step;

  Axis(double a, double b, int most_ticks) : low(a), high(b) {
    if (!(high - low > 1e-12 * std::max(std::abs(low), std::abs(high)))) {
      const double pad = std::max(std::abs(high) * 0.05, 1e-9);
      low -= pad;
      high += pad;
    }
    const double raw = (high - low) / most_ticks, power = std::pow(10, std::floor(std::log10(raw)));
    step = power * 10;
    for (const int round : {5, 2, 1})
      if (raw / power <= round) step = power * round;
  }
  void Round() {
    low = std::floor(low / step + 1e-9) * step;
    high = std::ceil(high / step - 1e-9) * step;
  }
  std::vector<double> Ticks() const {
    std::vector<double> ticks;
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
      ticks.push_back(i * step);
    return ticks;
  }
};

struct Frame {
  Axis x, y;
  double width = kNarrow;
  double X(double v) const {
    return kLeft + (v - x.low) / (x.high - x.low) * (width - kLeft - kRight);
  }
  double Y(double v) const {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  }
};

std::string Tick(double value, double step, bool percent) {
  const double shown = percent ? 100 * value : value, shown_step = percent ? 100 * step : step;
  const int decimals =
      std::clamp(static_cast<int>(std::ceil(-std::log10(shown_step) - 1e-9)), 0, 8);
  if (shown_step < 1e-5) return fmt::format("{:.1e}{}", shown, percent ? " %" : "");
  return fmt::format("{:.{}f}{}", std::abs(shown) < 1e-9 * shown_step ? 0.0 : shown, decimals,
                     percent ? " %" : "");
}

std::string Grid(const Frame& frame, const ChartLabels& labels) {
  const double width = frame.width;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" width=\"100%\" role=\"img\"><text class=\"title\" x=\"{}\" "
      "y=\"16\">{}</text>",
      width, kHeight, 4, labels.title);
  for (const double v : frame.y.Ticks()) {
    const double y = frame.Y(v);
    svg +=
        fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>",
                    kLeft, width - kRight, y, y, std::abs(v) < 1e-12 ? "zero" : "grid");
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", kLeft - 7,
                       y + 4, Tick(v, frame.y.step, labels.percent));
  }
  for (const double v : frame.x.Ticks())
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>",
                       frame.X(v), kHeight - kBottom + 17, Tick(v, frame.x.step, false));
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>",
                     (kLeft + width - kRight) / 2, kHeight - 4, labels.x);
  return svg;
}

std::string LegendItem(double& x, const std::string& name, const std::string& color, bool dashed) {
  const std::string item = fmt::format(
      "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"32\" y2=\"32\" stroke=\"{}\" "
      "stroke-width=\"3\"{}/><text x=\"{:.1f}\" y=\"36\">{}</text>",
      x, x + 20, color, dashed ? " stroke-dasharray=\"5 3\"" : "", x + 26, name);
  x += 44 + 7.0 * static_cast<double>(name.size());
  return item;
}

}  // namespace

std::string LineChart(const std::vector<Series>& series, const ChartLabels& labels) {
  double x0 = INFINITY, x1 = -INFINITY, y0 = 0, y1 = 0;
  for (const Series& s : series)
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      x0 = std::min(x0, s.x[i]);
      x1 = std::max(x1, s.x[i]);
      y0 = std::min(y0, s.y[i]);
      y1 = std::max(y1, s.y[i]);
    }
  if (!(x0 <= x1)) return "";
  Frame frame{Axis(x0, x1, 8), Axis(y0, y1, 6)};
  frame.y.Round();
  std::string svg = Grid(frame, labels);
  double legend = kLeft;
  for (const Series& s : series) {
    std::string points;
    for (std::size_t i = 0; i < s.x.size(); ++i)
      points += fmt::format("{:.1f},{:.1f} ", frame.X(s.x[i]), frame.Y(s.y[i]));
    svg +=
        fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2.2\"{}/>",
                    points, s.color, s.dashed ? " stroke-dasharray=\"6 4\"" : "");
    for (std::size_t i = 0; i < s.x.size() && s.x.size() <= 60; ++i)
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.8\" fill=\"{}\"/>",
                         frame.X(s.x[i]), frame.Y(s.y[i]), s.color);
    svg += LegendItem(legend, s.name, s.color, s.dashed);
  }
  return svg + "</svg>";
}

std::string HistogramChart(const std::vector<HistogramSeries>& series, double low, double high,
                           const ChartLabels& labels) {
  double most = 0;
  for (const HistogramSeries& s : series)
    for (const double share : s.shares) most = std::max(most, share);
  Frame frame{Axis(low, high, 8), Axis(0, std::max(most, 1e-6), 5)};
  frame.y.Round();
  std::string svg = Grid(frame, labels);
  double legend = kLeft;
  for (const HistogramSeries& s : series) {
    const double bin = (high - low) / static_cast<double>(s.shares.size());
    std::string path = fmt::format("M{:.1f} {:.1f}", frame.X(low), frame.Y(0));
    for (std::size_t i = 0; i < s.shares.size(); ++i) {
      const double left = frame.X(low + bin * static_cast<double>(i)),
                   right = frame.X(low + bin * static_cast<double>(i + 1)),
                   y = frame.Y(s.shares[i]);
      path += fmt::format("L{:.1f} {:.1f}L{:.1f} {:.1f}", left, y, right, y);
    }
    path += fmt::format("L{:.1f} {:.1f}Z", frame.X(high), frame.Y(0));
    svg += fmt::format(
        "<path d=\"{}\" fill=\"{}\" fill-opacity=\".32\" stroke=\"{}\" stroke-width=\"1.3\"/>",
        path, s.color, s.color);
    svg += LegendItem(legend, s.name, s.color, false);
  }
  return svg + "</svg>";
}

std::string DotChart(const std::vector<ChartMark>& marks, const ChartLabels& labels) {
  if (marks.empty()) return "";
  const auto [low, high] = std::minmax_element(
      marks.begin(), marks.end(), [](const ChartMark& a, const ChartMark& b) { return a.y < b.y; });
  // Space above for the names.
  const double reach = std::max(high->y - low->y, 20.0);
  Frame frame{Axis(0, 360, 12), Axis(low->y - 0.1 * reach, high->y + 0.6 * reach, 6), kWide};
  frame.x.step = 30;
  frame.y.Round();
  std::string svg = Grid(frame, labels);
  for (const ChartMark& mark : marks) {
    const double x = frame.X(mark.x), y = frame.Y(mark.y);
    svg +=
        fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", x, y, mark.color);
    svg += fmt::format(
        "<text class=\"small\" transform=\"translate({:.1f} {:.1f}) rotate(-58)\">{}</text>", x + 5,
        y - 5, Escape(mark.name));
  }
  return svg + "</svg>";
}

}  // namespace keypose::report
