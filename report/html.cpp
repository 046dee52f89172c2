#include "report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/size_of.h"

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

const char* const kStyle = R"css(
:root{--ink:#1d232b;--soft:#5c6672;--line:#e1e5ea;--paper:#fff;--wash:#f5f6f8;--accent:#2f5d8a;--good:#1f7a4d;--look:#a86a00;--bad:#b3261e}
*{box-sizing:border-box}
html{scroll-behavior:smooth}
body{margin:0;background:var(--wash);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
header.top{background:linear-gradient(120deg,#16202c,#2b4764);color:#fff;padding:30px 0 26px}
.wrap{max-width:1160px;margin:0 auto;padding:0 24px}
header.top h1{margin:0;font-size:30px;letter-spacing:-.01em;font-weight:650}
header.top p{margin:4px 0 0;color:#c5d2df}
.kicker{text-transform:uppercase;letter-spacing:.14em;font-size:12px;color:#9fb6cc;margin-bottom:6px}
nav{background:#fff;border-bottom:1px solid var(--line);position:sticky;top:0;z-index:5}
nav .wrap{display:flex;gap:22px;overflow-x:auto}
nav a{padding:11px 0;color:var(--soft);text-decoration:none;font-size:14px;white-space:nowrap}
nav a:hover{color:var(--accent)}
section{background:var(--paper);border:1px solid var(--line);border-radius:10px;padding:22px 26px 26px;margin:22px 0}
h2{margin:0 0 4px;font-size:21px;letter-spacing:-.01em}
h3{margin:26px 0 8px;font-size:16px}
.lead{color:var(--soft);margin:0 0 14px;max-width:85ch}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(140px,1fr));gap:12px;margin-top:22px}
.tile{background:rgba(255,255,255,.09);border:1px solid rgba(255,255,255,.16);border-radius:8px;padding:10px 14px}
.tile b{display:block;font-size:22px;font-weight:650;line-height:1.25}
.tile span{color:#bdcbd9;font-size:13px}
table{border-collapse:collapse;width:100%;font-size:14px}
.scroll{overflow-x:auto}
th{text-align:left;font-weight:600;color:var(--soft);border-bottom:2px solid var(--line);padding:6px 12px 6px 0;font-size:13px;vertical-align:bottom}
td{border-bottom:1px solid var(--line);padding:6px 12px 6px 0;vertical-align:middle}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
tr.mark td{background:#eef4fa;font-weight:600}
tr.past td{color:var(--soft)}
.facts{display:grid;grid-template-columns:repeat(auto-fill,minmax(215px,1fr));gap:0 26px;margin:10px 0 4px}
.facts div{display:flex;justify-content:space-between;gap:12px;border-bottom:1px solid var(--line);padding:5px 0}
.facts span{color:var(--soft)}
.facts b{font-weight:600;text-align:right;min-width:4.2em;font-variant-numeric:tabular-nums;overflow-wrap:anywhere}
figure{margin:16px 0 0}
figcaption{color:var(--soft);font-size:13px;margin-top:6px;max-width:90ch}
img{max-width:100%;height:auto;display:block;border-radius:6px}
.shots{display:grid;grid-template-columns:repeat(auto-fit,minmax(190px,1fr));gap:10px;margin-top:12px}
.shots figure{margin:0}
.shots img{width:100%;border:1px solid var(--line);background:#f6f7f9}
.wide{display:grid;grid-template-columns:repeat(auto-fit,minmax(320px,1fr));gap:16px;margin-top:12px}.wide figure{margin:0}.wide img{border:1px solid var(--line)}
.two{display:grid;grid-template-columns:repeat(auto-fit,minmax(440px,1fr));gap:22px}
@media(max-width:560px){.two{grid-template-columns:1fr}section{padding:18px 16px}}
.chip{display:inline-block;border-radius:20px;padding:1px 10px;font-size:12px;font-weight:600;white-space:nowrap}
.good{background:#e3f3ea;color:var(--good)}.look{background:#fdf1da;color:var(--look)}.wrong,.bad{background:#fbe5e3;color:var(--bad)}.note,.info{background:#e8eef5;color:var(--accent)}
#player .stage{position:relative;height:min(64vh,620px);background:radial-gradient(circle at 50% 40%,#fff,#e9edf2);border:1px solid var(--line);border-radius:8px;overflow:hidden;margin-top:12px;display:flex;justify-content:center}
#player .stage img{height:100%;width:auto;border-radius:0}#player .stage.live img{display:none}
#player canvas{width:100%;height:100%;display:block;touch-action:none;cursor:grab}
#player .controls{display:flex;flex-wrap:wrap;align-items:center;gap:8px 16px;margin:12px 0 6px;font-size:14px}#player .controls[hidden]{display:none}
#player .controls input[type=range]{flex:1 1 260px}#player .time{color:var(--soft);min-width:12.5em;font-variant-numeric:tabular-nums}
#player button{min-width:5em;padding:5px 14px;border:1px solid var(--accent);border-radius:6px;background:var(--accent);color:#fff;font:inherit;cursor:pointer}
#player select{font:inherit;padding:3px}#player label{white-space:nowrap}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(420px,1fr));gap:14px;margin-top:14px}
.card{display:flex;gap:18px;border:1px solid var(--line);border-left:5px solid;border-radius:8px;padding:14px 18px;background:#fff;color:inherit}
.card.good{border-left-color:var(--good)}.card.look{border-left-color:#e0a030}.card.wrong{border-left-color:var(--bad)}.card.note{border-left-color:var(--accent)}
.card.good,.card.look,.card.wrong,.card.note{background:#fff;color:var(--ink)}
.card img{width:150px;height:auto;align-self:flex-start}
.card h3{margin:2px 0 6px;font-size:18px}.card p{margin:6px 0 0}
.cure{color:#4a5560}
ul.verdicts{list-style:none;padding:0;margin:12px 0 0}
ul.verdicts li{display:grid;grid-template-columns:84px 1fr;gap:12px;padding:7px 0;border-bottom:1px solid var(--line)}
ul.verdicts li:last-child{border-bottom:0}
ul.verdicts .chip{justify-self:start;align-self:start;margin-top:2px}
.bar{background:#e9edf2;border-radius:3px;height:9px;min-width:120px;overflow:hidden}.bar i{display:block;height:100%;background:#5b87b3;border-radius:3px}
.bar i.reused{background:#b9c6d3}
details{margin-top:14px;border-top:1px solid var(--line);padding-top:10px}
summary{cursor:pointer;color:var(--accent);font-weight:600;font-size:14px}
.scale{display:flex;align-items:center;gap:10px;font-size:13px;color:var(--soft);margin-top:10px}
.scale i{display:block;width:240px;height:12px;border-radius:3px}
svg text{font:12px system-ui,-apple-system,"Segoe UI",Roboto,Arial,sans-serif;fill:#5c6672}
svg .title{font-weight:600;fill:#1d232b;font-size:13.5px}
svg .small{font-size:9.5px}
code{font:13px ui-monospace,Menlo,Consolas,monospace;background:var(--wash);padding:1px 5px;border-radius:4px}
footer{color:var(--soft);font-size:13px;padding:4px 0 40px}
@media print{nav{display:none}section{break-inside:avoid}body{background:#fff}}
)css";

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
  std::string text = size < 1e-4 ? fmt::format("{:.2e}", value)
                     : size < 1  ? fmt::format("{:.4f}", value)
                                 : fmt::format("{:.4g}", value);
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
         Escape(title) + "</title><style>" + kStyle + "</style></head><body>\n" + body +
         "</body></html>\n";
}

}  // namespace keypose::report
