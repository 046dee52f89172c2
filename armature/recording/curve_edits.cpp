#include "armature/recording/curve_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "core/io/text/files.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

constexpr int kLongestTake = 1000000;  // frames
constexpr int kLargestAmount = 1000000;
constexpr double kLimitSlack = 1e-6;

template <class Number>
std::optional<Number> WholeNumber(const std::string& word) {
  Number number{};
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (word.empty() || fault != std::errc() || end != word.data() + word.size()) return {};
  return number;
}

/// The words of one line, taken one after another.
class EditLine {
 public:
  EditLine(const std::string& text, const std::string& where, const Armature& armature)
      : where_(where), armature_(armature) {
    std::istringstream words(text.substr(0, text.find('#')));
    for (std::string word; words >> word;) words_.push_back(word);
  }
  bool empty() const { return words_.empty(); }

  CurveEdit Read() {
    CurveEdit edit;
    const std::string verb = Next("an edit");
    const std::vector<std::pair<std::string, EditKind>> verbs = {
        {"hold", EditKind::kHold}, {"set", EditKind::kSet},       {"add", EditKind::kAdd},
        {"move", EditKind::kMove}, {"delete", EditKind::kDelete}, {"repeat", EditKind::kRepeat},
        {"step", EditKind::kStep}};
    const auto known = std::find_if(verbs.begin(), verbs.end(),
                                    [&](const auto& entry) { return entry.first == verb; });
    if (known == verbs.end()) {
      std::vector<std::string> names;
      for (const auto& entry : verbs) names.push_back(entry.first);
      Refuse(fmt::format("'{}' is no edit; did you mean '{}'?", verb, NearestWord(verb, names)));
    }
    edit.kind = known->second;
    ReadRest(&edit);
    if (at_ < words_.size()) Refuse(fmt::format("'{}' is too much", words_[at_]));
    return edit;
  }

 private:
  void ReadRest(CurveEdit* edit) {
    const EditKind kind = edit->kind;
    if (kind == EditKind::kStep) return void(edit->by = Count(1, 1000));
    if (kind != EditKind::kDelete && kind != EditKind::kRepeat) edit->joint = Joint();
    Frames(edit);
    if (kind == EditKind::kSet || kind == EditKind::kAdd) edit->amount = Amount(edit->joint);
    if (kind == EditKind::kMove || kind == EditKind::kRepeat) {
      if (const std::string word = Next("'by'"); word != "by")
        Refuse(fmt::format("'{}' stands where 'by' is wanted", word));
      edit->by = Count(kind == EditKind::kMove ? -kLongestTake : 1, kLongestTake);
    }
  }
  std::string Next(const char* wanted) {
    if (at_ == words_.size()) Refuse(fmt::format("{} is missing at its end", wanted));
    return words_[at_++];
  }
  int Count(int least, int most) {
    const std::string word = Next("a number of frames");
    const std::optional<int> count = WholeNumber<int>(word);
    if (!count || *count < least || *count > most)
      Refuse(fmt::format("'{}' is no number of frames from {} to {}", word, least, most));
    return *count;
  }
  int Joint() {
    const std::string name = Next("a joint, or 'all',");
    if (name == "all") return -1;
    const int joint = armature_.JointOf(armature_.Find(name));
    if (joint >= 0) return joint;
    std::vector<std::string> names;
    for (const int node : armature_.joints) names.push_back(armature_.nodes[node].name);
    Refuse(
        fmt::format("no joint is called '{}'; did you mean '{}'?", name, NearestWord(name, names)));
  }
  /// `7` or `7-9`.
  void Frames(CurveEdit* edit) {
    const std::string word = Next("a frame, or frames such as 3-6,");
    const std::size_t dash = word.find('-');
    const std::optional<int> first = WholeNumber<int>(word.substr(0, dash)),
                             last = dash == std::string::npos
                                        ? first
                                        : WholeNumber<int>(word.substr(dash + 1));
    if (!first || !last || *first < 0 || *last < *first)
      Refuse(fmt::format("'{}' is no frame, and no frames such as 3-6", word));
    edit->first = *first;
    edit->last = *last;
  }
  double Amount(int joint) {
    const std::string word = Next("an amount");
    const std::optional<double> amount = WholeNumber<double>(word);
    if (!amount || !std::isfinite(*amount)) Refuse(fmt::format("'{}' is no number", word));
    if (std::abs(*amount) > kLargestAmount)
      Refuse(fmt::format("'{}' is beyond {}", word, kLargestAmount));
    if (joint >= 0) return *amount * EditUnitOf(armature_, joint).size;
    for (const int node : armature_.joints)
      if (armature_.nodes[node].kind != NodeKind::kJoint)
        Refuse("one amount for all does not do: some joints turn and some slide");
    return *amount * kDegree;
  }
  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(fmt::format("{}: {}", where_, what));
  }

  std::string where_;
  const Armature& armature_;
  std::vector<std::string> words_;
  std::size_t at_ = 0;
};

/// Does one edit after another.
class TakeEditor {
 public:
  TakeEditor(const Armature& armature, JointCurves* curves)
      : armature_(armature), curves_(*curves), values_(curves->values) {}

  void Do(const CurveEdit& edit) {
    if (edit.kind == EditKind::kStep) return Step(edit);
    if (edit.last >= values_.rows())
      Refuse(edit, fmt::format("frame {} is not there: the take has {} by then, counted from 0",
                               edit.last, values_.rows()));
    const int count = edit.last - edit.first + 1;
    if (edit.kind == EditKind::kDelete) return Delete(edit, count);
    if (edit.kind == EditKind::kRepeat) return Repeat(edit);
    const Eigen::Index joint = std::max(edit.joint, 0);
    auto part = values_.middleCols(joint, edit.joint < 0 ? values_.cols() : 1);
    auto rows = part.middleRows(edit.first, count);
    if (edit.kind == EditKind::kHold) rows = part.row(edit.first).replicate(count, 1).eval();
    if (edit.kind == EditKind::kSet) rows.setConstant(edit.amount);
    if (edit.kind == EditKind::kAdd) rows.array() += edit.amount;
    if (edit.kind == EditKind::kMove) Move(edit, part);
    if (edit.kind == EditKind::kSet || edit.kind == EditKind::kAdd) CheckLimits(edit);
  }

 private:
  void CheckLimits(const CurveEdit& edit) const {
    const int last = edit.joint < 0 ? static_cast<int>(values_.cols()) - 1 : edit.joint;
    for (int joint = std::max(edit.joint, 0); joint <= last; ++joint)
      for (int f = edit.first; f <= edit.last; ++f) CheckLimits(edit, joint, f);
  }
  void CheckLimits(const CurveEdit& edit, int joint, int frame) const {
    const ArmatureNode& node = armature_.nodes[armature_.joints[joint]];
    const EditUnit unit = EditUnitOf(armature_, joint);
    const double value = values_(frame, joint);
    // A limit may be written with fewer digits than it has.
    const double slack = kLimitSlack * unit.size;
    if (value >= node.low - slack && value <= node.high + slack) return;
    Refuse(edit, fmt::format("joint '{}' would be at {:.6g}{}{} in frame {}, and its limits are "
                             "{:.6g} to {:.6g}",
                             node.name, value / unit.size, *unit.name ? " " : "", unit.name, frame,
                             node.low / unit.size, node.high / unit.size));
  }
  /// Ones to twos keeps every second frame, twos to ones shows each twice.
  void Step(const CurveEdit& edit) {
    const std::int64_t film = std::int64_t{curves_.step} * values_.rows();
    const std::int64_t count = (film + edit.by - 1) / edit.by;
    if (count > kLongestTake) Refuse(edit, "the take would become too long");
    Eigen::MatrixXd stepped(count, values_.cols());
    for (std::int64_t f = 0; f < count; ++f)
      stepped.row(f) = values_.row(f * edit.by / curves_.step);
    values_ = stepped;
    curves_.step = edit.by;
  }
  void Delete(const CurveEdit& edit, int count) {
    if (count == values_.rows()) Refuse(edit, "no frame would be left");
    const Eigen::Index after = values_.rows() - edit.last - 1;
    values_.middleRows(edit.first, after) = values_.bottomRows(after).eval();
    values_.conservativeResize(values_.rows() - count, Eigen::NoChange);
  }
  void Repeat(const CurveEdit& edit) {
    if (edit.first != edit.last) Refuse(edit, "one frame is repeated, not several");
    if (values_.rows() + edit.by > kLongestTake) Refuse(edit, "the take would become too long");
    const Eigen::Index after = values_.rows() - edit.first - 1;
    const Eigen::MatrixXd rest = values_.bottomRows(after);
    values_.conservativeResize(values_.rows() + edit.by, Eigen::NoChange);
    values_.middleRows(edit.first + 1, edit.by) =
        values_.row(edit.first).replicate(edit.by, 1).eval();
    values_.bottomRows(after) = rest;
  }
  template <class Part>
  void Move(const CurveEdit& edit, Part& part) {
    const int count = edit.last - edit.first + 1, to = edit.first + edit.by;
    if (to < 0 || to + count > part.rows())
      Refuse(edit, fmt::format("frames {} to {} would go to {} to {}, and the take has 0 to {}",
                               edit.first, edit.last, to, to + count - 1, part.rows() - 1));
    const Eigen::MatrixXd moved = part.middleRows(edit.first, count);
    // What they leave stands as the frame before; at the take's start as they themselves begin.
    const Eigen::MatrixXd stays = part.row(std::max(edit.first - 1, 0));
    part.middleRows(edit.first, count) = stays.replicate(count, 1);
    part.middleRows(to, count) = moved;
  }
  [[noreturn]] static void Refuse(const CurveEdit& edit, const std::string& what) {
    throw InputError(fmt::format("line {} of the edits: {}", edit.line, what));
  }

  const Armature& armature_;
  JointCurves& curves_;
  Eigen::MatrixXd& values_;
};

}  // namespace

std::vector<CurveEdit> ParseCurveEdits(const std::string& text, const std::string& file,
                                       const Armature& armature) {
  std::vector<CurveEdit> edits;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    EditLine words(line, fmt::format("{}, line {}", file, ++number), armature);
    if (words.empty()) continue;
    edits.push_back(words.Read());
    edits.back().line = number;
  }
  if (edits.empty()) throw InputError(file + " has no edit, such as `hold all 3-6`");
  return edits;
}

EditUnit EditUnitOf(const Armature& armature, int joint) {
  if (armature.nodes[armature.joints[joint]].kind == NodeKind::kJoint) return {kDegree, "degrees"};
  const double metres = armature.metres_per_unit;
  if (metres <= 0) return {1, ""};
  for (const EditUnit& unit : {EditUnit{0.001, "mm"}, {0.01, "cm"}, {0.0254, "in"}})
    if (metres == unit.size) return unit;
  return {metres, "m"};
}

JointCurves EditedCurves(const Armature& armature, JointCurves curves,
                         const std::vector<CurveEdit>& edits) {
  TakeEditor editor(armature, &curves);
  for (const CurveEdit& edit : edits) editor.Do(edit);
  return curves;
}

}  // namespace keypose::armature
