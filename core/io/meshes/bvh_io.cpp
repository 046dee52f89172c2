#include "core/io/meshes/bvh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr std::array<const char*, 6> kChannelNames{"Xposition", "Yposition", "Zposition",
                                                   "Xrotation", "Yrotation", "Zrotation"};
// Far more than any skeleton has; a file with more is damaged.
constexpr int kMostJoints = 10000, kMostFrames = 10000000;

/// Words of a text with the lines they stand in.
class Words {
 public:
  Words(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // editors on Windows write it
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
  }

  std::string_view Next() {
    SkipSpace();
    while (text_.substr(at_).starts_with("#") || text_.substr(at_).starts_with("//")) {
      Line();  // a comment
      SkipSpace();
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && !IsSpace(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  /// The rest of the line, without spaces at its ends.
  std::string Line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string rest(text_.substr(at_, end - at_));
    at_ = end;
    while (!rest.empty() && IsSpace(rest.back())) rest.pop_back();
    while (!rest.empty() && IsSpace(rest.front())) rest.erase(rest.begin());
    return rest;
  }
  void Expect(std::string_view word) {
    const std::string_view got = Next();
    if (got != word) Fail(fmt::format("'{}' was expected, not '{}'", word, got));
  }
  double Number() {
    const std::string_view word = Next();
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      Fail(word.empty() ? "it ends where a number was expected"
                        : fmt::format("'{}' is not a number", word));
    return value;
  }
  int Count(int most) {
    const double value = Number();
    if (value != std::floor(value) || value < 0 || value > most)
      Fail(fmt::format("{} is not a usable count", value));
    return static_cast<int>(value);
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError(
        fmt::format("{}, line {}: {}; it is not a whole BVH file", name_, line_, what));
  }

 private:
  void SkipSpace() {
    while (at_ < text_.size() && IsSpace(text_[at_])) line_ += text_[at_++] == '\n';
  }
  static bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// Some programs write "XPosition" or "xrotation".
bool SameLetters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

BvhChannel ChannelNamed(std::string_view word, const Words& words) {
  for (std::size_t i = 0; i < kChannelNames.size(); ++i)
    if (SameLetters(word, kChannelNames[i])) return static_cast<BvhChannel>(i);
  words.Fail(fmt::format("'{}' is not a channel", word));
}

void ReadOffset(Words& words, ClipJoint* joint) {
  words.Expect("{");
  words.Expect("OFFSET");
  for (int i = 0; i < 3; ++i) joint->offset[i] = words.Number();
}

void ReadHierarchy(Words& words, MotionClip* clip) {
  std::vector<int> open;
  const auto add = [&](const std::string& name) {
    if (static_cast<int>(clip->joints.size()) >= kMostJoints) words.Fail("too many joints");
    ClipJoint joint;
    joint.name = name;
    joint.parent = open.empty() ? -1 : open.back();
    ReadOffset(words, &joint);
    open.push_back(static_cast<int>(clip->joints.size()));
    clip->joints.push_back(joint);
  };
  words.Expect("HIERARCHY");
  words.Expect("ROOT");
  add(words.Line());
  while (!open.empty()) {
    const std::string_view word = words.Next();
    if (word == "CHANNELS") {
      const int count = words.Count(6);
      for (int i = 0; i < count; ++i)
        clip->joints[open.back()].channels.push_back(ChannelNamed(words.Next(), words));
    } else if (word == "JOINT") {
      add(words.Line());
    } else if (word == "End") {
      words.Line();
      add("");
    } else if (word == "}") {
      open.pop_back();
    } else {
      words.Fail(fmt::format("'{}' was not expected", word));
    }
  }
}

void WriteJoint(const MotionClip& clip, const std::vector<std::vector<int>>& children, int j,
                int depth, std::string* text) {
  const ClipJoint& joint = clip.joints[j];
  const std::string indent(static_cast<std::size_t>(depth), '\t');
  const char* kind = joint.name.empty() ? "End Site" : "JOINT ";
  if (j == 0) kind = "ROOT ";
  *text += fmt::format("{0}{1}{2}\n{0}{{\n{0}\tOFFSET {3:.6f} {4:.6f} {5:.6f}\n", indent, kind,
                       joint.name, joint.offset.x(), joint.offset.y(), joint.offset.z());
  if (!joint.channels.empty()) {
    *text += fmt::format("{}\tCHANNELS {}", indent, joint.channels.size());
    for (const BvhChannel c : joint.channels)
      *text += fmt::format(" {}", kChannelNames[static_cast<std::size_t>(c)]);
    *text += "\n";
  }
  for (const int child : children[j]) WriteJoint(clip, children, child, depth + 1, text);
  *text += indent + "}\n";
}

}  // namespace

MotionClip ParseBvh(const std::string& text, const std::string& name) {
  MotionClip clip;
  Words words(text, name);
  ReadHierarchy(words, &clip);
  words.Expect("MOTION");
  words.Expect("Frames:");
  const int frames = words.Count(kMostFrames);
  words.Expect("Frame");
  words.Expect("Time:");
  clip.frame_time_s = words.Number();
  if (!(clip.frame_time_s > 0)) words.Fail("the time of a frame must be positive");
  const int channels = clip.channel_count();
  // A number takes two bytes at least: a count beyond that is damaged, and is not allocated.
  if (static_cast<double>(frames) * channels > 0.5 * static_cast<double>(text.size()) + 1)
    words.Fail(fmt::format("it has not the {} frames that it names", frames));
  clip.values.resize(frames, channels);
  for (int f = 0; f < frames; ++f)
    for (int c = 0; c < channels; ++c) clip.values(f, c) = words.Number();
  return clip;
}

MotionClip ReadBvh(const std::filesystem::path& path) {
  return ParseBvh(ReadFile(path), PrintableName(path.filename()));
}

std::string BvhText(const MotionClip& clip) {
  std::vector<std::vector<int>> children(clip.joints.size());
  for (std::size_t j = 1; j < clip.joints.size(); ++j)
    children[clip.joints[j].parent].push_back(static_cast<int>(j));
  std::string text = "HIERARCHY\n";
  WriteJoint(clip, children, 0, 0, &text);
  text += fmt::format("MOTION\nFrames: {}\nFrame Time: {:.7f}\n", clip.frame_count(),
                      clip.frame_time_s);
  for (int f = 0; f < clip.frame_count(); ++f) {
    for (Eigen::Index c = 0; c < clip.values.cols(); ++c)
      text += fmt::format("{}{:.6f}", c ? " " : "", clip.values(f, c));
    text += "\n";
  }
  return text;
}

void WriteBvh(const std::filesystem::path& path, const MotionClip& clip) {
  WriteFile(path, BvhText(clip));
}

}  // namespace keypose
