#include "export/film/exposure_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace keypose::exporting {
namespace {

constexpr double kWaveWidth = 120, kRowHeight = 14;  // px
constexpr int kRowsOfAPage = 60;

constexpr char kStyle[] =
    "body{font:11px sans-serif;color:#000;background:#fff;margin:1em}h1{font-size:15px;margin:0}"
    "p{margin:.3em 0 .8em}table{border-collapse:collapse}thead{display:table-header-group}"
    "th{text-align:left;border-bottom:1.5px solid #000}td,th{padding:0 .6em}"
    "td{border-bottom:.5px solid #999;height:14px;line-height:14px;white-space:nowrap}"
    "tr.second td{border-top:2px solid #000}tr.page{break-before:page}td.key{font-weight:bold}"
    "td.number{text-align:right;font-variant-numeric:tabular-nums}td.sound{padding:0}"
    "td.notes{width:18em}svg{display:block;fill:#555}@page{size:A4;margin:12mm}";

std::string Text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else
      safe += c;
  }
  return safe;
}

/// What the pictures show: a key's pose, the share of the way to the next, or nothing new.
class Shown {
 public:
  explicit Shown(const Scene& scene) : scene_(scene) {
    for (const KeyMark& key : scene.keys) poses_.emplace(key.frame, key.pose);
  }
  bool IsKey(int frame) const { return poses_.count(frame) > 0; }
  /// @param before  the frame of the picture before; below 0: there is none
  std::string Of(int frame, int before) const {
    const auto pose = poses_.find(frame);
    if (pose != poses_.end() && (before < 0 || frame != before)) return Text(pose->second);
    if (before >= 0 && scene_.clip.picture[frame] == scene_.clip.picture[before]) return "&#124;";
    if (scene_.frame_t.empty()) return Text(scene_.frame_names[frame]);
    const double share = scene_.frame_t[frame] - std::floor(scene_.frame_t[frame]);
    return fmt::format("{:.0f} %", 100 * share);
  }

 private:
  const Scene& scene_;
  std::map<int, std::string> poses_;
};

std::string Wave(const SoundRange& range) {
  const double middle = kWaveWidth / 2;
  return fmt::format(
      "<td class=\"sound\"><svg width=\"{0:g}\" height=\"{1:g}\"><rect x=\"{2:.2f}\" "
      "width=\"{3:.2f}\" height=\"{1:g}\"/></svg></td>",
      kWaveWidth, kRowHeight, middle * (1 + std::max(-1.f, range.low)),
      std::max(0.5, middle * (std::min(1.f, range.high) - std::max(-1.f, range.low))));
}

std::string Row(const Shown& shown, const std::vector<int>& order, int i, double fps,
                const SoundRange* range) {
  const auto seconds = static_cast<std::int64_t>(std::floor(i / fps + 1e-9));
  const auto before = static_cast<std::int64_t>(std::floor((i - 1) / fps + 1e-9));
  const bool new_second = i == 0 || seconds > before;
  const auto first_of_second =
      static_cast<std::int64_t>(std::ceil(static_cast<double>(seconds) * fps - 1e-9));
  std::string kind = new_second ? "second" : "";
  if (i > 0 && i % kRowsOfAPage == 0) kind += kind.empty() ? "page" : " page";
  return fmt::format(
      "<tr{}><td class=\"number\">{}</td><td class=\"number\">{}:{:02}</td><td{}>{}</td>{}"
      "<td class=\"notes\"></td></tr>\n",
      kind.empty() ? "" : fmt::format(" class=\"{}\"", kind), i + 1, seconds, i - first_of_second,
      shown.IsKey(order[i]) ? " class=\"key\"" : "", shown.Of(order[i], i > 0 ? order[i - 1] : -1),
      range ? Wave(*range) : "");
}

}  // namespace

std::vector<SoundRange> SoundRanges(const Sound& sound, int pictures, double fps) {
  std::vector<SoundRange> ranges(static_cast<std::size_t>(pictures));
  for (int i = 0; i < pictures; ++i) {
    const auto at = [&](double picture) {
      return std::min<std::int64_t>(std::llround(picture / fps * kSoundRate), sound.length());
    };
    const auto first = sound.samples.begin() + 2 * at(i),
               end = sound.samples.begin() + 2 * at(i + 1);
    if (first == end) continue;
    const auto [low, high] = std::minmax_element(first, end);
    ranges[i] = {*low, *high};
  }
  return ranges;
}

FormatFiles MakeExposureSheet(const Scene& scene, const Sound& sound) {
  const std::vector<int> order = RoundOf(scene);
  const int pictures = static_cast<int>(order.size());
  const double fps = scene.playback.fps;
  const bool heard = sound.length() > 0;
  const std::vector<SoundRange> ranges = SoundRanges(sound, heard ? pictures : 0, fps);
  const Shown shown(scene);
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Exposure "
      "sheet</title><style>{}</style></head><body>\n<h1>{}</h1><p>{} pictures, {:.2f} s, {:g} a "
      "second{}</p>\n<table><thead><tr><th>picture</th><th>time</th><th>pose</th>{}<th>notes</th>"
      "</tr></thead><tbody>\n",
      kStyle, Text(scene.name), pictures, pictures / fps, fps,
      heard ? fmt::format("; sound until {:.2f} s", sound.seconds()) : "",
      heard ? "<th>sound</th>" : "");
  for (int i = 0; i < pictures; ++i)
    page += Row(shown, order, i, fps, heard ? &ranges[i] : nullptr);
  FormatFiles made;
  made.error_over_diagonal = -1;
  made.files.push_back({"character_sheet.html", page + "</tbody></table></body></html>\n"});
  made.measured["pictures"] = pictures;
  return made;
}

}  // namespace keypose::exporting
