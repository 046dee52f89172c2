#include "report/html/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose::report {
namespace {

std::string Grouped(long long value) {
  std::string digits = std::to_string(std::llabs(value));
  for (int i = SizeOf(digits) - 3; i > 0; i -= 3)
    digits.insert(static_cast<std::size_t>(i), "\u202f");
  return (value < 0 ? "\u2212" : "") + digits;
}

bool LooksNumeric(const std::string& cell) {
  if (cell.empty()) return false;
  if (cell.rfind("\u2212", 0) == 0 || cell == "\u2013" || cell == "N/A") return true;
  return std::isdigit(static_cast<unsigned char>(cell[0])) || (cell[0] == '+' && cell.size() > 1);
}

}  // namespace

std::string Escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string Pretty(double value) {
  if (!std::isfinite(value)) return "not finite";
  if (value == 0) return "0";
  const double size = std::abs(value);
  if (value == std::round(value) && size < 1e15) return Grouped(static_cast<long long>(value));
  if (size >= 10000) return Grouped(std::llround(value));
  std::string text = fmt::format("{:.4g}", value);
  if (size < 1) text = fmt::format("{:.4f}", value);
  if (size < 1e-4) text = fmt::format("{:.2e}", value);
  if (text[0] == '-') text = "\u2212" + text.substr(1);
  return text;
}

std::string PrettySeconds(double seconds) {
  if (seconds < 0.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 99.5) return fmt::format("{:.1f} s", seconds);
  const long long whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string PrettyBytes(double bytes) {
  if (bytes <= 0) return "\u2013";
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6)
                     : fmt::format("{:.2f} GB", bytes / 1e9);
}

std::string Percent(double share) {
  const double p = 100 * std::abs(share);
  return (share < 0 ? "\u2212" : "") +
         (p < 1 && p != 0 ? fmt::format("{:.2f}\u00a0%", p) : fmt::format("{:.1f}\u00a0%", p));
}

std::string Bold(const std::string& html) { return "<b>" + html + "</b>"; }

std::string Joined(const std::vector<std::string>& names) {
  constexpr std::size_t kNamesShown = 6;
  std::string text;
  const std::size_t shown = std::min(names.size(), kNamesShown);
  for (std::size_t i = 0; i < shown; ++i) text += (i ? ", " : "") + Escape(names[i]);
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

std::string Base64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned block = static_cast<unsigned char>(bytes[i]) << 16;
    if (i + 1 < bytes.size()) block |= static_cast<unsigned char>(bytes[i + 1]) << 8;
    if (i + 2 < bytes.size()) block |= static_cast<unsigned char>(bytes[i + 2]);
    for (int k = 0; k < 4; ++k)
      out += i + static_cast<std::size_t>(k) > bytes.size() ? '='
                                                            : kDigits[block >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string Table::Html() const {
  std::vector<bool> numeric(header_.size(), !rows_.empty());
  for (const Row& row : rows_)
    for (std::size_t c = 0; c < numeric.size() && c < row.cells.size(); ++c)
      numeric[c] = numeric[c] && (row.cells[c].empty() || LooksNumeric(row.cells[c]));
  std::string html = "<div class=scroll><table" +
                     (class_.empty() ? "" : " class=\"" + class_ + "\"") + "><thead><tr>";
  for (std::size_t c = 0; c < header_.size(); ++c)
    html += (numeric[c] ? "<th class=n>" : "<th>") + header_[c] + "</th>";
  html += "</tr></thead><tbody>";
  for (const Row& row : rows_) {
    html += row.css_class.empty() ? "<tr>" : "<tr class=\"" + row.css_class + "\">";
    for (std::size_t c = 0; c < row.cells.size(); ++c)
      html += (c < numeric.size() && numeric[c] ? "<td class=n>" : "<td>") + row.cells[c] + "</td>";
    html += "</tr>";
  }
  return html + "</tbody></table></div>\n";
}

std::string Facts(const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::string html = "<div class=facts>";
  for (const auto& [name, value] : pairs)
    html += "<div><span>" + name + "</span><b>" + value + "</b></div>";
  return html + "</div>\n";
}

std::string Figure(const std::string& inner, const std::string& caption) {
  return "<figure>" + inner + (caption.empty() ? "" : "<figcaption>" + caption + "</figcaption>") +
         "</figure>\n";
}

std::string Image(const std::string& data_uri, const std::string& alternative) {
  return "<img src=\"" + data_uri + "\" alt=\"" + Escape(alternative) + "\">";
}

std::string ColorScale(const std::vector<std::string>& stops, const std::string& lowest,
                       const std::string& highest) {
  return fmt::format(
      "<div class=scale>{}<i style=\"background:linear-gradient(90deg,{})\"></i>{}</div>\n", lowest,
      fmt::join(stops, ","), highest);
}

std::string Page(const std::string& title, const std::string& body) {
  return "<!doctype html>\n<html lang=en><head><meta charset=utf-8><meta "
         "http-equiv=Content-Security-Policy content=\"default-src 'none'; "
         "img-src data: blob:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\"><meta "
         "name=viewport "
         "content=\"width=device-width,initial-scale=1\"><title>" +
         Escape(title) + "</title><style>" + PageStyle() + "</style></head><body>\n" + body +
         "</body></html>\n";
}

}  // namespace keypose::report
