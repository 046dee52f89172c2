// Pieces of a self-contained HTML page: escaped text, tables, figures, and charts drawn as inline
// SVG.
#pragma once

#include <string>
#include <vector>

namespace keypose::report {

/// The style sheet of the page, report/html/style.css.
const char* PageStyle();

std::string Escape(const std::string& text);

/// A number for reading: about four digits, thousands grouped, powers of ten for very large or
/// small values.
std::string Pretty(double value);
/// "12.3 s", "4 min 05 s", "1 h 02 min"; "0.12 s" below a second.
std::string PrettySeconds(double seconds);
/// "812 MB", "1.35 GB".
std::string PrettyBytes(double bytes);
std::string Percent(double share);  ///< "12.3 %"
std::string Bold(const std::string& html);
/// "a.jpg, b.jpg and 3 more": up to six.
std::string Joined(const std::vector<std::string>& names);

std::string Base64(const std::string& bytes);

/// A table. Cells are HTML. Cells that begin like a number are right-aligned.
class Table {
 public:
  explicit Table(std::vector<std::string> header, std::string css_class = "")
      : header_(std::move(header)), class_(std::move(css_class)) {}
  void Add(std::vector<std::string> cells, const std::string& css_class = "") {
    rows_.push_back({std::move(cells), css_class});
  }
  bool empty() const { return rows_.empty(); }
  std::string Html() const;

 private:
  struct Row {
    std::vector<std::string> cells;
    std::string css_class;
  };
  std::vector<std::string> header_;
  std::string class_;
  std::vector<Row> rows_;
};

/// Name and value pairs, in columns.
std::string Facts(const std::vector<std::pair<std::string, std::string>>& pairs);
std::string Figure(const std::string& inner, const std::string& caption);
std::string Image(const std::string& data_uri, const std::string& alternative);

struct Series {
  std::string name, color;
  std::vector<double> x, y;
  bool dashed = false;
};
struct ChartLabels {
  std::string title, x, y;
  bool percent = false;  ///< y is a share, shown in per cent
};
/// A line chart with axes, ticks and legend, and a dot at each point.
std::string LineChart(const std::vector<Series>& series, const ChartLabels& labels);

/// Shares over equal bins of [low, high], drawn as overlaid bars.
struct HistogramSeries {
  std::string name, color;
  std::vector<double> shares;
};
std::string HistogramChart(const std::vector<HistogramSeries>& series, double low, double high,
                           const ChartLabels& labels);

struct ChartMark {
  std::string name, color;
  double x, y;
};
/// Dots with slanted names, so that the names of close dots do not overlap.
std::string DotChart(const std::vector<ChartMark>& marks, const ChartLabels& labels);

/// A horizontal colour scale from 0 to `highest`; `stops` are CSS colours.
std::string ColorScale(const std::vector<std::string>& stops, const std::string& lowest,
                       const std::string& highest);

/// The whole page: a head with styles, then `body`.
std::string Page(const std::string& title, const std::string& body);

}  // namespace keypose::report
