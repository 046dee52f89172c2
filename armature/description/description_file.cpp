#include "armature/description/description_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature {

namespace {

constexpr std::size_t kMostDepth = 200, kMostNodes = 10000;
constexpr int kLargestSensor = 4095;

const std::vector<std::string> kHeaderWords = {"units", "rodaxis", "scale_is", "counts", "node"};
const std::vector<std::string> kNodeWords = {"name",   "axis",    "slide",  "sensor", "scale",
                                             "length", "rodaxis", "limits", "node"};

double MetresOf(WordReader& words) {
  static const std::map<std::string, double> kUnits = {
      {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"none", 0}};
  const Word& word = words.Next();
  const auto unit = kUnits.find(word.text);
  if (unit == kUnits.end()) words.RefuseWord(word, {"mm", "cm", "m", "in", "none"});
  return unit->second;
}

Eigen::Vector3d UnitAxis(WordReader& words, const std::string& what) {
  const Word& place = words.Peek();
  Eigen::Vector3d axis;
  for (int i = 0; i < 3; ++i) axis[i] = words.Number("a number of " + what);
  if (!(axis.norm() > 1e-9))
    words.Fail(place, what + " has no direction: one number must not be 0");
  return axis.normalized();
}

}  // namespace

/// One pass over the words; open nodes on a stack of its own, so that no nesting can overflow the
/// program's.
class DescriptionParser {
 public:
  DescriptionParser(const std::string& text, const std::string& file) : file_(file) {
    result_.words_ = SplitWords(text, file_);
  }

  DescriptionFile Parse() {
    WordReader words(result_.words_, file_);
    while (!words.AtEnd()) {
      const Word& word = words.Next();
      if (word.text == "node") {
        ReadTree(words, word);
      } else {
        ReadHeader(words, word);
      }
    }
    if (nodes().empty())
      words.Fail(words.Peek(), "there is no node in it; it begins with `node {`");
    for (std::size_t n = 0; n < nodes().size(); ++n) Finish(static_cast<int>(n));
    return std::move(result_);
  }

 private:
  std::vector<ArmatureNode>& nodes() { return result_.armature_.nodes; }

  void ReadHeader(WordReader& words, const Word& word) {
    const std::string& key = word.text;
    const bool known =
        std::find(kHeaderWords.begin(), kHeaderWords.end(), key) != kHeaderWords.end();
    if (!known) words.RefuseWord(word, kHeaderWords);
    if (!nodes().empty())
      words.Fail(word, fmt::format("'{}' must stand before the first node", key));
    if (!header_.insert(key).second) words.Fail(word, fmt::format("'{}' is given twice", key));
    if (key == "units") result_.armature_.metres_per_unit = MetresOf(words);
    if (key == "rodaxis") rod_axis_ = UnitAxis(words, "rodaxis");
    if (key == "counts")
      result_.armature_.counts_per_revolution = words.Whole("counts", 1, 1 << 20);
    if (key == "scale_is") {
      const Word& sense = words.Next();
      if (sense.text != "encoder_per_joint" && sense.text != "joint_per_encoder")
        words.RefuseWord(sense, {"encoder_per_joint", "joint_per_encoder"});
      if (sense.text == "joint_per_encoder") result_.scale_is_ = ScaleSense::kJointPerEncoder;
    }
  }

  /// A node at the top with all within it.
  void ReadTree(WordReader& words, const Word& top) {
    Begin(words, top);
    while (!open_.empty()) {
      const Word& word = words.Next();
      if (word.text == "}")
        open_.pop_back();
      else if (word.text == "node")
        Begin(words, word);
      else
        ReadAttribute(words, word);
    }
  }

  void Begin(WordReader& words, const Word& word) {
    words.Expect("{");
    if (open_.size() >= kMostDepth)
      words.Fail(word,
                 fmt::format("nodes are nested more than {} deep; is a '}}' missing?", kMostDepth));
    if (nodes().size() >= kMostNodes)
      words.Fail(word, fmt::format("there are more than {} nodes", kMostNodes));
    ArmatureNode node;
    node.parent = open_.empty() ? -1 : open_.back();
    node.axis = rod_axis_;
    node.line = word.line;
    open_.push_back(static_cast<int>(nodes().size()));
    nodes().push_back(node);
    begins_.push_back(word);
    seen_.emplace_back();
    result_.places_.emplace_back();
  }

  void ReadAttribute(WordReader& words, const Word& word) {
    const auto n = static_cast<std::size_t>(open_.back());
    const std::string& key = word.text;
    if (std::find(kNodeWords.begin(), kNodeWords.end(), key) == kNodeWords.end())
      words.RefuseWord(word, kNodeWords);
    if (!seen_[n].insert(key).second)
      words.Fail(word, fmt::format("'{}' is given twice in this node", key));
    ArmatureNode& node = nodes()[n];
    if (key == "name") ReadName(words, n);
    if (key == "axis" || key == "slide" || key == "rodaxis") node.axis = UnitAxis(words, key);
    if (key == "sensor") ReadSensor(words, n);
    if (key == "scale") ReadScale(words, n);
    if (key == "limits") ReadLimits(words, n);
    if (key == "length") {
      const Word& place = words.Peek();
      node.length = words.Number("length");
      if (node.length < 0)
        words.Fail(place, "a length cannot be negative; give the rod another rodaxis");
    }
  }

  void ReadName(WordReader& words, std::size_t n) {
    const Word& place = words.Peek();
    nodes()[n].name = words.Name("a name");
    const auto [other, is_new] = names_.emplace(nodes()[n].name, n);
    if (!is_new)
      words.Fail(place, fmt::format("the name {} is also that of the node in line {}; each node "
                                    "needs its own",
                                    Quoted(nodes()[n].name), nodes()[other->second].line));
  }

  void ReadSensor(WordReader& words, std::size_t n) {
    const Word& place = words.Peek();
    result_.places_[n].sensor = words.at();
    const int sensor = nodes()[n].sensor = words.Whole("sensor", 0, kLargestSensor);
    const auto [other, is_new] = sensors_.emplace(sensor, n);
    if (!is_new)
      words.Fail(place, fmt::format("sensor {} is also that of the node {}in line {}; an encoder "
                                    "watches one joint",
                                    sensor, NameOf(other->second), nodes()[other->second].line));
  }

  void ReadScale(WordReader& words, std::size_t n) {
    const Word& place = words.Peek();
    result_.places_[n].scale = words.at();
    nodes()[n].scale = words.Number("scale");
    if (!(std::abs(nodes()[n].scale) >= 1e-9)) words.Fail(place, "scale must not be 0");
  }

  void ReadLimits(WordReader& words, std::size_t n) {
    const Word& place = words.Peek();
    nodes()[n].low = words.Number("the lower limit");
    nodes()[n].high = words.Number("the upper limit");
    if (nodes()[n].low > nodes()[n].high)
      words.Fail(place, "the lower limit is above the upper one; write the lower one first");
  }

  /// "'rightKneeBend' ", or nothing while it has no name.
  std::string NameOf(std::size_t n) {
    return nodes()[n].name.empty() ? "" : Quoted(nodes()[n].name) + " ";
  }

  /// Attributes that do not go together, once all of them are known.
  void CheckTogether(std::size_t n) {
    const auto has = [&](const char* key) { return seen_[n].contains(key); };
    const auto fail = [&](const std::string& what) {
      FailAt(file_, begins_[n], fmt::format("the node {}{}", NameOf(n), what));
    };
    if (!has("name")) fail("has no name; each needs one");
    if (has("axis") && has("slide")) fail("has an axis and a slide; make two nodes of it");
    const bool moves = has("axis") || has("slide");
    if (moves && has("length"))
      fail("is a joint and a rod; put the rod into a node of its own within this one");
    if (moves && !has("sensor")) fail("turns, but has no sensor; give it `sensor INDEX`");
    if (!moves && has("sensor")) fail("has a sensor, but no axis; give it `axis X Y Z`");
    if (!moves && has("scale")) fail("has a scale, but no axis");
    if (!moves && has("limits")) fail("has limits, but no axis");
    if (!has("length") && has("rodaxis")) fail("has a rodaxis, but no length");
  }

  void Finish(int index) {
    const auto n = static_cast<std::size_t>(index);
    CheckTogether(n);
    ArmatureNode& node = nodes()[n];
    const double metres = result_.armature_.metres_per_unit;
    const double unit = metres > 0 ? metres : 1;
    if (seen_[n].contains("axis")) node.kind = NodeKind::kJoint;
    if (seen_[n].contains("slide")) node.kind = NodeKind::kSlide;
    if (seen_[n].contains("length")) node.kind = NodeKind::kRod;
    node.length *= unit;
    if (!node.moves()) return;
    if (result_.scale_is_ == ScaleSense::kJointPerEncoder) node.scale = 1 / node.scale;
    if (node.kind == NodeKind::kSlide) node.scale /= unit;
    const double limit_unit = node.kind == NodeKind::kSlide ? unit : kDegree;
    node.low *= limit_unit;
    node.high *= limit_unit;
    result_.armature_.joints.push_back(index);
  }

  std::string file_;
  DescriptionFile result_;
  Eigen::Vector3d rod_axis_ = Eigen::Vector3d::UnitY();
  std::set<std::string> header_;
  std::vector<int> open_;                    ///< whose closing brace has not come yet
  std::vector<Word> begins_;                 ///< the word `node` of each
  std::vector<std::set<std::string>> seen_;  ///< attributes of each
  std::map<std::string, std::size_t> names_;
  std::map<int, std::size_t> sensors_;
};

DescriptionFile DescriptionFile::Parse(const std::string& text, const std::string& file) {
  return DescriptionParser(text, file).Parse();
}

void DescriptionFile::SetScale(int node, double scale) {
  const auto n = static_cast<std::size_t>(node);
  ArmatureNode& changed = armature_.nodes[n];
  changed.scale = scale;
  const double metres = armature_.metres_per_unit;
  if (changed.kind == NodeKind::kSlide && metres > 0) scale *= metres;
  const double written = scale_is_ == ScaleSense::kJointPerEncoder ? 1 / scale : scale;
  if (places_[n].scale) {
    words_[places_[n].scale].text = fmt::format("{}", written);
    return;
  }
  const std::size_t behind = places_[n].sensor + 1;
  const Word key{" ", "scale", changed.line, 1},
      value{" ", fmt::format("{}", written), changed.line, 1};
  words_.insert(words_.begin() + static_cast<std::ptrdiff_t>(behind), {key, value});
  for (Places& places : places_) {
    if (places.sensor >= behind) places.sensor += 2;
    if (places.scale >= behind) places.scale += 2;
  }
  places_[n].scale = behind + 1;
}

namespace {

std::string AxisText(const Eigen::Vector3d& axis) {
  return fmt::format("{} {} {}", axis.x(), axis.y(), axis.z());
}

/// Attributes of a node behind its name, each in a line of its own.
std::string AttributesText(const ArmatureNode& node, double unit, const std::string& indent) {
  std::string text;
  const auto line = [&](const std::string& words) { text += indent + words + "\n"; };
  if (node.kind == NodeKind::kRod) {
    line(fmt::format("length {}", node.length / unit));
    if (node.axis != Eigen::Vector3d::UnitY()) line("rodaxis " + AxisText(node.axis));
  }
  if (!node.moves()) return text;
  const bool slides = node.kind == NodeKind::kSlide;
  line((slides ? "slide " : "axis ") + AxisText(node.axis));
  line(fmt::format("sensor {}", node.sensor));
  line(fmt::format("scale {}", slides ? node.scale * unit : node.scale));
  const double limit_unit = slides ? unit : kDegree;
  if (std::isfinite(node.low))
    line(fmt::format("limits {} {}", node.low / limit_unit, node.high / limit_unit));
  return text;
}

}  // namespace

std::string DescriptionText(const Armature& armature) {
  const double unit = armature.metres_per_unit > 0 ? 0.001 : 1;
  std::string text = armature.metres_per_unit > 0 ? "units mm\n" : "";
  if (armature.counts_per_revolution != 1024)
    text += fmt::format("counts {}\n", armature.counts_per_revolution);
  std::vector<int> open;
  const auto close = [&] {
    open.pop_back();
    text += std::string(2 * open.size(), ' ') + "}\n";
  };
  for (std::size_t n = 0; n < armature.nodes.size(); ++n) {
    const ArmatureNode& node = armature.nodes[n];
    while (!open.empty() && open.back() != node.parent) close();
    const std::string indent(2 * open.size(), ' ');
    open.push_back(static_cast<int>(n));
    text += fmt::format("{0}node {{\n{0}  name {1}\n", indent, node.name);
    text += AttributesText(node, unit, indent + "  ");
  }
  while (!open.empty()) close();
  return text;
}

}  // namespace keypose::armature
