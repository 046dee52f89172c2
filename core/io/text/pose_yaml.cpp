#include "core/io/text/pose_yaml.h"

#include <algorithm>

#include "core/io/text/yaml_edit.h"
#include "core/io/text/yaml_text.inc"

namespace keypose {

using namespace yaml_text;

namespace {

[[noreturn]] void NoSuchPose(const std::string& pose) {
  throw YamlEditError(fmt::format("there is no pose '{}'", pose));
}

void RequirePoseIn(const std::string& text, const std::string& pose) {
  const auto poses = PosesIn(text);
  if (std::find(poses.begin(), poses.end(), pose) == poses.end()) NoSuchPose(pose);
}

std::string FlowList(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + YamlScalar(name);
  return "[" + list + "]";
}

/// The list of keys, whether the timeline is that list or has it under `keys`.
YAML::Node KeysOf(const YAML::Node& root) {
  const YAML::Node timeline = root["timeline"];
  if (!timeline.IsDefined()) return {};
  if (!timeline.IsMap()) return timeline;
  const YAML::Node keys = timeline["keys"];
  return keys.IsDefined() ? keys : YAML::Node();
}

/// The scalar that names a key's pose.
YAML::Node PoseOfKey(const YAML::Node& key) {
  if (!key.IsMap()) return key;
  const YAML::Node pose = key["pose"];
  return pose.IsDefined() ? pose : YAML::Node();
}

bool IsName(const YAML::Node& node, const std::string& name) {
  return node.IsDefined() && node.IsScalar() && node.Scalar() == name;
}

/// The frames of the filmed shot that show a pose, or nothing.
YAML::Node ShowsOf(const YAML::Node& root) {
  const YAML::Node shot = root["shot"];
  const YAML::Node shows = shot.IsDefined() && shot.IsMap() ? shot["shows"] : YAML::Node();
  return shows.IsDefined() ? shows : YAML::Node();
}

/// The scalars outside of `poses` that are a pose's name.
std::vector<YAML::Node> NamesOf(const YAML::Node& root, const std::string& pose) {
  std::vector<YAML::Node> names;
  const auto add = [&](const YAML::Node& node) {
    if (IsName(node, pose)) names.push_back(node);
  };
  add(root["template"]);
  const YAML::Node keys = KeysOf(root);
  if (keys.IsSequence())
    for (const YAML::Node& key : keys) add(PoseOfKey(key));
  const YAML::Node shows = ShowsOf(root);
  if (shows.IsMap())
    for (const auto& frame : shows) add(frame.second);
  return names;
}

Span SpanOfScalar(const std::string& text, const YAML::Node& scalar) {
  const std::size_t at = PositionOf(scalar);
  const bool quoted = text[at] == '"' || text[at] == '\'';
  return {at, quoted ? QuotedEnd(text, at) : at + scalar.Scalar().size()};
}

YAML::Node KeyNode(const YAML::Node& poses, const std::string& pose) {
  for (const auto& entry : poses)
    if (entry.first.IsScalar() && entry.first.Scalar() == pose) return entry.first;
  NoSuchPose(pose);
}

/// From the end of what stands before an entry to its own end: with the comments before it.
std::vector<Span> BlockPieces(const std::string& text, const Entry& poses) {
  std::vector<Span> pieces;
  std::size_t begin = NextLine(text, AfterColon(text, poses.key));
  for (const auto& pair : poses.value) {
    const Entry entry = EntryOf(text, pair.first, pair.second, false);
    pieces.push_back({begin, entry.span.end});
    begin = entry.span.end;
  }
  return pieces;
}

std::vector<Span> FlowPieces(const std::string& text, const Entry& poses) {
  std::vector<Span> pieces;
  for (const auto& pair : poses.value)
    pieces.push_back(EntryOf(text, pair.first, pair.second, true).span);
  return pieces;
}

/// The pieces' texts in another order, with what is between them where it was.
std::string Permuted(const std::string& text, const std::vector<Span>& pieces,
                     const std::vector<std::size_t>& order) {
  std::string whole = text.substr(0, pieces.front().begin);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Span& piece = pieces[order[i]];
    std::string one = text.substr(piece.begin, piece.end - piece.begin);
    const std::size_t next = i + 1 < pieces.size() ? pieces[i + 1].begin : text.size();
    const bool line = pieces[i].end == next && !one.empty() && one.back() != '\n';
    whole += one + (line && i + 1 < pieces.size() ? "\n" : "") +
             text.substr(pieces[i].end, next - pieces[i].end);
  }
  return whole;
}

std::string WithTimelineList(const std::string& text, const std::vector<std::string>& names) {
  if (!Parsed(text)["timeline"].IsDefined()) return text;
  return names.size() < 2 ? WithoutValue(text, {"timeline"})
                          : WithValue(text, {"timeline"}, FlowList(names));
}

/// A node as YAML in flow style.
std::string FlowOf(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "null";
  if (node.IsScalar()) {
    const bool quoted = node.Tag() == "!";  // as "24" is not 24
    return quoted ? nlohmann::json(node.Scalar()).dump() : YamlScalar(node.Scalar());
  }
  std::string text;
  const auto join = [&](const std::string& one) { text += (text.empty() ? "" : ", ") + one; };
  if (node.IsMap())
    for (const auto& pair : node) join(FlowOf(pair.first) + ": " + FlowOf(pair.second));
  else
    for (const YAML::Node& item : node) join(FlowOf(item));
  return node.IsMap() ? "{" + text + "}" : "[" + text + "]";
}

/// With the keys of `before`, if those of `text` are those of `left`.
std::string WithKeysBack(const std::string& text, const std::string& left,
                         const std::string& before) {
  const YAML::Node old = Parsed(before), now = Parsed(text);
  const YAML::Node keys = KeysOf(old);
  if (!keys.IsSequence() || FlowOf(KeysOf(now)) != FlowOf(KeysOf(Parsed(left)))) return text;
  if (!now["timeline"].IsDefined()) return WithValue(text, {"timeline"}, FlowOf(old["timeline"]));
  std::vector<std::string> items;
  for (const YAML::Node& key : keys) items.push_back(FlowOf(key));
  const bool map = now["timeline"].IsMap();
  return WithItems(text, map ? YamlPath{"timeline", "keys"} : YamlPath{"timeline"}, items);
}

/// The keys that stay, as YAML.
std::string WithoutKeysOf(const std::string& text, const std::string& pose) {
  const YAML::Node root = Parsed(text), keys = KeysOf(root);
  if (!keys.IsSequence()) return text;
  std::vector<std::string> items;
  for (const YAML::Node& key : keys)
    if (!IsName(PoseOfKey(key), pose)) items.push_back(FlowOf(key));
  if (items.size() == keys.size()) return text;
  const bool map = root["timeline"].IsMap();
  if (items.empty()) return WithoutValue(text, {"timeline"});
  const YamlPath place = map ? YamlPath{"timeline", "keys"} : YamlPath{"timeline"};
  return WithItems(text, place, items);
}

}  // namespace

std::vector<std::string> PosesIn(const std::string& text) {
  std::vector<std::string> poses;
  const YAML::Node root = Parsed(text);
  if (!root.IsMap()) return poses;
  const YAML::Node map = root["poses"];
  if (map.IsDefined() && map.IsMap())
    for (const auto& entry : map) poses.push_back(entry.first.Scalar());
  return poses;
}

bool TimelineOnlyListsPoses(const std::string& text) {
  const YAML::Node root = Parsed(text);
  if (!root.IsMap()) return true;
  const YAML::Node timeline = root["timeline"];
  if (!timeline.IsDefined() || timeline.IsNull()) return true;
  const std::vector<std::string> poses = PosesIn(text);
  if (!timeline.IsSequence() || timeline.size() != poses.size()) return false;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (!IsName(timeline[i], poses[i])) return false;
  return true;
}

std::string WithPose(const std::string& text, const std::string& pose, bool few) {
  std::vector<std::string> poses = PosesIn(text);
  if (std::find(poses.begin(), poses.end(), pose) != poses.end())
    throw YamlEditError(fmt::format("there is a pose '{}' already", pose));
  const bool extend = TimelineOnlyListsPoses(text);
  const std::string folder = YamlScalar("photos/" + pose);
  const std::string value = few ? fmt::format("{{photos: {}, method: fit}}", folder) : folder;
  std::string edited = WithValue(text, {"poses", pose}, value);
  poses.push_back(pose);
  if (poses.size() == 1 && !Parsed(text)["template"].IsDefined())
    edited = WithValue(edited, {"template"}, YamlScalar(pose));
  if (!extend || poses.size() < 2) return edited;
  return WithValue(edited, {"timeline"}, FlowList(poses));
}

std::string WithPoseRenamed(const std::string& text, const std::string& pose,
                            const std::string& name) {
  RequireEditable(text);
  RequirePoseIn(text, pose);
  const std::vector<std::string> poses = PosesIn(text);
  if (std::find(poses.begin(), poses.end(), name) != poses.end())
    throw YamlEditError(fmt::format("there is a pose '{}' already", name));
  const YAML::Node root = Parsed(text);
  std::vector<Span> spans = {SpanOfScalar(text, KeyNode(root["poses"], pose))};
  for (const YAML::Node& one : NamesOf(root, pose)) spans.push_back(SpanOfScalar(text, one));
  std::sort(spans.begin(), spans.end(),
            [](const Span& a, const Span& b) { return a.begin > b.begin; });
  std::string edited = text;
  for (const Span& span : spans) edited = Replaced(edited, span, YamlScalar(name));
  YAML::Node wanted = Parsed(text);
  for (YAML::Node& one : [&] { return NamesOf(wanted, pose); }()) one = name;
  const YAML::Node value = wanted["poses"][pose];
  wanted["poses"].remove(pose);
  wanted["poses"][name] = value;
  return Checked(edited, wanted);
}

std::string WithoutPose(const std::string& text, const std::string& pose) {
  RequirePoseIn(text, pose);
  std::vector<std::string> poses = PosesIn(text);
  const bool lists = TimelineOnlyListsPoses(text);
  std::erase(poses, pose);
  std::string edited = lists ? WithTimelineList(text, poses) : WithoutKeysOf(text, pose);
  const YAML::Node shows = ShowsOf(Parsed(text));
  if (shows.IsMap())
    for (const auto& frame : shows)
      if (IsName(frame.second, pose))
        edited = WithoutValue(edited, {"shot", "shows", frame.first.Scalar()});
  return WithoutValue(edited, {"poses", pose});
}

std::string WithPoseBack(const std::string& text, const std::string& pose,
                         const std::string& before) {
  const std::string left = WithoutPose(before, pose);
  if (text == left) return before;
  const auto poses = PosesIn(text);
  if (std::find(poses.begin(), poses.end(), pose) != poses.end())
    throw YamlEditError(fmt::format("there is a pose '{}' already", pose));
  const bool lists = Parsed(before)["timeline"].IsDefined() && TimelineOnlyListsPoses(before) &&
                     TimelineOnlyListsPoses(text);
  std::string edited = lists ? WithPose(text, pose, false) : WithKeysBack(text, left, before);
  edited = WithValue(edited, {"poses", pose}, PoseValue(before, pose));
  const YAML::Node shown = ShowsOf(Parsed(before)), now = ShowsOf(Parsed(text));
  if (!now.IsMap() || !shown.IsMap()) return edited;
  for (const auto& frame : shown)
    if (IsName(frame.second, pose) && !now[frame.first.Scalar()].IsDefined())
      edited = WithValue(edited, {"shot", "shows", frame.first.Scalar()}, YamlScalar(pose));
  return edited;
}

std::string WithPoseOrder(const std::string& text, const std::vector<std::string>& order) {
  RequireEditable(text);
  const std::vector<std::string> poses = PosesIn(text);
  if (poses.size() != order.size() ||
      !std::is_permutation(poses.begin(), poses.end(), order.begin()))
    throw YamlEditError("it has other poses");
  if (poses.size() < 2) return text;
  const bool lists = TimelineOnlyListsPoses(text);
  const Entry entry = *FindEntry(text, Parsed(text), "poses");
  std::vector<std::size_t> numbers;
  for (const std::string& pose : order)
    numbers.push_back(
        static_cast<std::size_t>(std::find(poses.begin(), poses.end(), pose) - poses.begin()));
  const auto pieces = IsFlow(entry.value) ? FlowPieces(text, entry) : BlockPieces(text, entry);
  const std::string edited = Checked(Permuted(text, pieces, numbers), Parsed(text));
  if (PosesIn(edited) != order) throw YamlEditError("its form is unusual; change it in an editor");
  return lists ? WithTimelineList(edited, order) : edited;
}

std::string TemplateIn(const std::string& text) {
  const YAML::Node named = Parsed(text)["template"];
  if (named.IsDefined() && named.IsScalar()) return named.Scalar();
  const std::vector<std::string> poses = PosesIn(text);
  return poses.empty() ? "" : poses.front();
}

std::string MethodIn(const std::string& text, const std::string& pose) {
  RequirePoseIn(text, pose);
  const YAML::Node rule = Parsed(text)["poses"][pose];
  const YAML::Node method = rule.IsMap() ? rule["method"] : YAML::Node();
  return method.IsDefined() && method.IsScalar() ? method.Scalar() : "";
}

std::string WithMethod(const std::string& text, const std::string& pose,
                       const std::string& method) {
  RequirePoseIn(text, pose);
  const YamlPath path = {"poses", pose, "method"};
  if (method.empty()) return WithoutValue(text, path);
  const YAML::Node rule = Parsed(text)["poses"][pose];
  if (rule.IsMap()) return WithValue(text, path, method);
  const std::string folder = rule.IsScalar() ? rule.Scalar() : "photos/" + pose;
  return WithValue(text, {"poses", pose},
                   fmt::format("{{photos: {}, method: {}}}", YamlScalar(folder), method));
}

std::string PoseValue(const std::string& text, const std::string& pose) {
  RequirePoseIn(text, pose);
  return FlowOf(Parsed(text)["poses"][pose]);
}

}  // namespace keypose
