#include "core/io/meshes/bvh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "core/io/meshes/clip_kind.h"
#include "core/io/text/files.h"
#include "core/io/text/text_file.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr std::array<const char*, 6> kChannelNames{"Xposition", "Yposition", "Zposition",
                                                   "Xrotation", "Yrotation", "Zrotation"};
constexpr std::array<const char*, 3> kScaleNames{"Xscale", "Yscale", "Zscale"};
// Far more than any skeleton or clip has; a file with more is damaged.
constexpr int kMostJoints = 10000, kMostFrames = 10000000, kMostChannels = 9;

char Lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool SameLetters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return Lower(x) == Lower(y); });
}

/// Words of a text with the lines they stand in. A brace is a word of its own.
class Words {
 public:
  Words(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  /// Empty at the end.
  std::string_view Next() {
    SkipSpace();
    while (text_.substr(at_).starts_with("#") || text_.substr(at_).starts_with("//")) {
      at_ = std::min(text_.find('\n', at_), text_.size());  // a comment
      SkipSpace();
    }
    const std::size_t begin = at_;
    if (at_ < text_.size() && IsBrace(text_[at_])) return text_.substr(at_++, 1);
    while (at_ < text_.size() && !IsSpace(text_[at_]) && !IsBrace(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  /// The next word, which stays.
  std::string_view Peek() {
    const std::size_t at = at_;
    const int line = line_;
    const std::string_view word = Next();
    at_ = at;
    line_ = line;
    return word;
  }
  /// The rest of the line, up to a brace, without spaces at its ends.
  std::string Name() {
    const std::size_t end = std::min(text_.find_first_of("{}\n", at_), text_.size());
    std::string rest(text_.substr(at_, end - at_));
    at_ = end;
    while (!rest.empty() && IsSpace(rest.back())) rest.pop_back();
    while (!rest.empty() && IsSpace(rest.front())) rest.erase(rest.begin());
    return rest;
  }
  void Expect(std::string_view word) {
    const std::string_view got = Next();
    if (!SameLetters(got, word)) Fail(fmt::format("'{}' was expected, not '{}'", word, got));
  }
  /// Letters, with or without spaces between and behind them, and a colon: "Frame Time:.0333".
  void Label(std::string_view letters) {
    Peek();
    std::size_t matched = 0;
    for (SkipToWord(); at_ < text_.size(); ++at_) {
      if (IsSpace(text_[at_]) && text_[at_] != '\n') continue;
      if (matched == letters.size() && text_[at_] == ':') return void(++at_);
      if (matched == letters.size() || Lower(text_[at_]) != letters[matched]) break;
      ++matched;
    }
    Fail(fmt::format("'{}:' was expected", letters == "frames" ? "Frames" : "Frame Time"));
  }
  double Number() {
    const std::string_view word = Next();
    if (word.empty()) Fail("it ends where a number was expected");
    std::string_view digits = word;
    // from_chars does not know the plus
    if (digits.starts_with("+") && !digits.starts_with("+-")) digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool read = error == std::errc() && end == digits.data() + digits.size();
    if (read && std::isfinite(value)) return value;
    if (word.find(',') != std::string_view::npos)
      Fail(fmt::format("'{}' has a comma; export it again with decimal points", word));
    Fail(fmt::format("'{}' is not a number", word));
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
  /// To the word that Next() would take, over comments.
  void SkipToWord() {
    const std::string_view word = Next();
    at_ -= word.size();
  }
  static bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  static bool IsBrace(char c) { return c == '{' || c == '}'; }

  std::string_view text_;
  std::string name_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// What a number of a frame is: of the channels that a clip keeps, or a scale.
struct Column {
  int joint = 0;
  int scaled_axis = -1;  ///< 0, 1, 2: a scale along that axis
};

struct BvhFile {
  MotionClip clip;
  std::vector<Column> columns;
  std::vector<std::vector<double>> frames;  ///< as in the file, scales too
};

bool IsPosition(BvhChannel channel) { return channel < BvhChannel::kXrotation; }

void ReadChannels(Words& words, int joint, BvhFile* file) {
  const int count = words.Count(kMostChannels);
  for (int i = 0; i < count; ++i) {
    const std::string_view word = words.Next();
    Column column{joint, -1};
    std::size_t known = 0;
    while (known < kChannelNames.size() && !SameLetters(word, kChannelNames[known])) ++known;
    for (int axis = 0; axis < 3; ++axis)
      if (SameLetters(word, kScaleNames[static_cast<std::size_t>(axis)])) column.scaled_axis = axis;
    std::vector<BvhChannel>& channels = file->clip.joints[joint].channels;
    const auto channel = static_cast<BvhChannel>(known);
    if (std::find(channels.begin(), channels.end(), channel) != channels.end() &&
        IsPosition(channel))
      words.Fail(fmt::format("the joint has '{}' twice", word));
    if (known < kChannelNames.size())
      channels.push_back(channel);
    else if (column.scaled_axis < 0)
      words.Fail(fmt::format("'{}' is not a channel", word));
    file->columns.push_back(column);
  }
}

/// Joints are numbered as they come, and so are their channels, whatever hangs on them.
class HierarchyReader {
 public:
  HierarchyReader(Words& words, BvhFile* file) : words_(words), file_(*file) {}

  void Read() {
    words_.Expect("HIERARCHY");
    while (SameLetters(words_.Peek(), "ROOT")) {
      words_.Next();
      Open(words_.Name());
      while (!open_.empty()) ReadWord();
    }
    if (file_.clip.joints.empty()) words_.Expect("ROOT");
  }

 private:
  void Open(const std::string& name) {
    if (static_cast<int>(file_.clip.joints.size()) >= kMostJoints) words_.Fail("too many joints");
    words_.Expect("{");
    ClipJoint joint;
    joint.name = name;
    joint.parent = open_.empty() ? -1 : open_.back();
    open_.push_back(static_cast<int>(file_.clip.joints.size()));
    placed_.push_back(false);
    file_.clip.joints.push_back(joint);
  }
  void ReadWord() {
    const std::string_view word = words_.Next();
    if (SameLetters(word, "OFFSET")) {
      for (int i = 0; i < 3; ++i) file_.clip.joints[open_.back()].offset[i] = words_.Number();
      placed_[open_.back()] = true;
    } else if (SameLetters(word, "CHANNELS")) {
      RequireLast();
      ReadChannels(words_, open_.back(), &file_);
    } else if (SameLetters(word, "JOINT")) {
      Open(words_.Name());
    } else if (SameLetters(word, "End") || SameLetters(word, "EndSite")) {
      words_.Name();  // "Site", and a name that some programs add
      Open("");
    } else if (word == "}") {
      if (!placed_[open_.back()]) words_.Fail("a joint has no OFFSET");
      open_.pop_back();
    } else {
      words_.Fail(fmt::format("'{}' was not expected", word));
    }
  }
  /// Numbers of a frame come in the order of the CHANNELS lines.
  void RequireLast() const {
    if (open_.back() + 1 != static_cast<int>(file_.clip.joints.size()))
      words_.Fail("a joint's CHANNELS stand behind its children");
  }

  Words& words_;
  BvhFile& file_;
  std::vector<int> open_;
  std::vector<char> placed_;
};

void Note(std::vector<std::string>* notes, const std::string& note) {
  if (notes) notes->push_back(note);
}

/// Programs write 1 / 30 as 0.0333333; the last of 10,000 frames would begin too early.
double AtWholeRate(double frame_time_s) {
  constexpr double kRounding_s = 6e-7;  // of six decimals
  const double whole = 1 / std::round(1 / frame_time_s);
  return std::abs(whole - frame_time_s) < kRounding_s ? whole : frame_time_s;
}

void ReadMotion(Words& words, const std::string& name, BvhFile* file,
                std::vector<std::string>* notes) {
  words.Expect("MOTION");
  words.Label("frames");
  const int said = words.Count(kMostFrames);
  words.Label("frametime");
  file->clip.frame_time_s = words.Number();
  if (!(file->clip.frame_time_s > 0)) words.Fail("the time of a frame must be positive");
  if (file->clip.frame_time_s > 1)
    Note(notes, fmt::format("{}: a frame lasts {} s; is that a rate? A BVH file has 1 / rate here",
                            name, file->clip.frame_time_s));
  if (file->clip.frame_time_s < 0.5) file->clip.frame_time_s = AtWholeRate(file->clip.frame_time_s);
  const std::size_t channels = file->columns.size();
  if (channels == 0) words.Fail("its joints have no channels");
  while (!words.Peek().empty()) {
    std::vector<double> frame(channels);
    for (double& number : frame) number = words.Number();
    file->frames.push_back(std::move(frame));
  }
  const auto found = static_cast<int>(file->frames.size());
  if (std::abs(found - said) > 1 || (found == 0 && said > 0))
    words.Fail(fmt::format("it says that it has {} frames, but has {}", said, found));
  if (found != said)
    Note(notes, fmt::format("{} says that it has {} frames, but has {}, which are all used", name,
                            said, found));
}

/// For each frame the joint's scale, the same along its axes; empty: none, or always 1.
/// @param columns  the joint's scales
Eigen::ArrayXd ScalesOf(const BvhFile& file, const std::vector<std::size_t>& columns,
                        const std::string& joint, const Words& words) {
  constexpr double kSame = 1e-5;  // as files round
  if (columns.empty() || file.frames.empty()) return {};
  Eigen::ArrayXd scales(static_cast<Eigen::Index>(file.frames.size()));
  for (std::size_t f = 0; f < file.frames.size(); ++f) {
    double least = file.frames[f][columns[0]], most = least;
    for (const std::size_t c : columns) {
      least = std::min(least, file.frames[f][c]);
      most = std::max(most, file.frames[f][c]);
    }
    if (!(least > 0) || most - least > kSame * most)
      words.Fail(
          fmt::format("joint {} is scaled by {} to {} in frame {}; only a scale that is the "
                      "same along all axes, and above 0, can be used: bake it, or leave "
                      "the scale channels out, and export again",
                      joint, least, most, f));
    scales[static_cast<Eigen::Index>(f)] = most;
  }
  if ((scales - 1).abs().maxCoeff() <= kSame) return {};
  return scales;
}

/// Fills the clip's values, joint after joint. What a scaled joint carries has its places scaled:
/// the numbers of its position channels, or else its offset, which becomes three position channels.
class ValuesWriter {
 public:
  ValuesWriter(const BvhFile& file, const Words& words) : file_(file), clip_(file.clip) {
    for (int j = 0; j < static_cast<int>(clip_.joints.size()); ++j) AddJoint(j, words);
  }
  MotionClip Clip() {
    clip_.values.resize(static_cast<Eigen::Index>(file_.frames.size()),
                        static_cast<Eigen::Index>(columns_.size()));
    if (file_.frames.empty()) return clip_;
    for (std::size_t c = 0; c < columns_.size(); ++c)
      clip_.values.col(static_cast<Eigen::Index>(c)) = columns_[c];
    return clip_;
  }

 private:
  void AddJoint(int j, const Words& words) {
    ClipJoint& joint = clip_.joints[j];
    const auto count = static_cast<Eigen::Index>(file_.frames.size());
    const Eigen::ArrayXd above = joint.parent < 0 ? Eigen::ArrayXd() : carried_[joint.parent];
    const bool scaled = above.size() > 0;
    const bool moved = std::any_of(joint.channels.begin(), joint.channels.end(), IsPosition);
    if (scaled && !moved) AddOffset(above, &joint);
    std::size_t kept = scaled && !moved ? 3 : 0;
    std::vector<std::size_t> scales;
    // the file's columns come in the order of the joints
    for (; next_ < file_.columns.size() && file_.columns[next_].joint == j; ++next_) {
      if (file_.columns[next_].scaled_axis >= 0) {
        scales.push_back(next_);
        continue;
      }
      Eigen::ArrayXd column(count);
      for (Eigen::Index f = 0; f < count; ++f) column[f] = file_.frames[f][next_];
      if (IsPosition(joint.channels[kept++]) && scaled) column *= above;
      columns_.push_back(column);
    }
    Eigen::ArrayXd carried = ScalesOf(file_, scales, joint.name, words);
    if (carried.size() == 0)
      carried = above;
    else if (scaled)
      carried *= above;
    carried_.push_back(carried);
  }
  void AddOffset(const Eigen::ArrayXd& scale, ClipJoint* joint) {
    joint->channels.insert(joint->channels.begin(), {BvhChannel::kXposition, BvhChannel::kYposition,
                                                     BvhChannel::kZposition});
    for (int axis = 0; axis < 3; ++axis) columns_.push_back(scale * joint->offset[axis]);
    joint->offset *= scale[0];
  }

  const BvhFile& file_;
  MotionClip clip_;
  std::size_t next_ = 0;  ///< of the file's columns
  std::vector<Eigen::ArrayXd> columns_;
  std::vector<Eigen::ArrayXd> carried_;  ///< of each joint, for each frame; empty: 1
};

/// Joints without an offset of their own take the place that they have in the first frame.
void PlaceByFirstFrame(MotionClip* clip) {
  Eigen::Index column = 0;
  for (ClipJoint& joint : clip->joints) {
    const bool placeless = joint.parent >= 0 && joint.offset.isZero() && clip->frame_count() > 0;
    for (const BvhChannel channel : joint.channels) {
      if (placeless && IsPosition(channel))
        joint.offset[static_cast<int>(channel)] = clip->values(0, column);
      ++column;
    }
  }
}

/// Nothing in a file tells, but a body that moves turns by more than a few degrees.
void NoteRadians(const MotionClip& clip, const std::string& name, std::vector<std::string>* notes) {
  constexpr double kTurn = 6.2832, kMoves = 0.5;
  if (clip.frame_count() < 2) return;
  double most = 0, moved = 0;
  Eigen::Index column = 0;
  for (const ClipJoint& joint : clip.joints)
    for (const BvhChannel channel : joint.channels) {
      const auto angles = clip.values.col(column++);
      if (IsPosition(channel)) continue;
      most = std::max(most, angles.cwiseAbs().maxCoeff());
      moved = std::max(moved, angles.maxCoeff() - angles.minCoeff());
    }
  if (most > kTurn || moved < kMoves) return;
  Note(notes, fmt::format("all turns of {} lie within {:.2f}; are they radians? BVH has degrees: "
                          "they are taken as such; if the figure hardly moves, export it in "
                          "degrees",
                          name, most));
}

void WriteJoint(const MotionClip& clip, const std::vector<std::vector<int>>& children, int j,
                int depth, std::string* text) {
  const ClipJoint& joint = clip.joints[j];
  const std::string indent(static_cast<std::size_t>(depth), '\t');
  const char* kind = joint.name.empty() ? "End Site" : "JOINT ";
  if (joint.parent < 0) kind = "ROOT ";
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

MotionClip ParseBvh(const std::string& text, const std::string& name,
                    std::vector<std::string>* notes) {
  if (const std::string other = OtherClip(text); !other.empty())
    throw InputError(name + " " + other);
  BvhFile file;
  const std::string plain = PlainText(text);
  Words words(plain, name);
  HierarchyReader(words, &file).Read();
  ReadMotion(words, name, &file, notes);
  MotionClip clip = ValuesWriter(file, words).Clip();
  PlaceByFirstFrame(&clip);
  NoteRadians(clip, name, notes);
  return clip;
}

MotionClip ReadBvh(const std::filesystem::path& path, std::vector<std::string>* notes) {
  return ParseBvh(ReadFile(path), PrintableName(path.filename()), notes);
}

std::string BvhText(const MotionClip& clip) {
  std::vector<std::vector<int>> children(clip.joints.size());
  for (std::size_t j = 0; j < clip.joints.size(); ++j)
    if (clip.joints[j].parent >= 0) children[clip.joints[j].parent].push_back(static_cast<int>(j));
  std::string text = "HIERARCHY\n";
  for (std::size_t j = 0; j < clip.joints.size(); ++j)
    if (clip.joints[j].parent < 0) WriteJoint(clip, children, static_cast<int>(j), 0, &text);
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
