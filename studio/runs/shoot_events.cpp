#include "studio/runs/shoot_events.h"

#include <initializer_list>
#include <nlohmann/json.hpp>

namespace keypose::studio {

using nlohmann::json;

namespace {

std::string TextOf(const json& event, const char* field) {
  const auto found = event.find(field);
  return found != event.end() && found->is_string() ? found->get<std::string>() : "";
}

bool IsSkip(const json& event) {
  return TextOf(event, "event") == "accepted" && TextOf(event, "command") == "skip";
}

bool IsOneOf(const std::string& name, std::initializer_list<const char*> names) {
  for (const char* one : names)
    if (name == one) return true;
  return false;
}

/// Whether two `ring` events are of the same ring. Fields that are missing are equal.
bool IsSameRing(const json& one, const json& other) {
  return one.value("ring", json()) == other.value("ring", json()) &&
         one.value("flip", json()) == other.value("flip", json());
}

/// Whether nothing is left to be known of `old` once `now` has come.
bool Replaces(const json& now, const json& old) {
  const std::string event = TextOf(now, "event"), before = TextOf(old, "event");
  if (event == "photograph")
    return (before == event && TextOf(old, "photograph") == TextOf(now, "photograph")) ||
           (IsSkip(old) && TextOf(old, "id") == TextOf(now, "photograph"));
  if (event == "ring") return before == event && IsSameRing(now, old);
  if (event == "findings") return false;
  if (event == "fault" || event == "recovered") return IsOneOf(before, {"fault", "recovered"});
  if (event == "ask") return IsOneOf(before, {"ask", "refused"});
  if (event == "accepted" || event == "refused")
    return IsSkip(old) ? IsSkip(now) && TextOf(old, "id") == TextOf(now, "id")
                       : IsOneOf(before, {"accepted", "refused"});
  if (event == "state") {
    const std::string state = TextOf(now, "state");
    return before == event || (before == "ask" && state != "asking") ||
           (before == "recovered" && state == "turning");
  }
  return before == event;
}

/// Takes findings that are told anew out of an older event; false: nothing of it is left.
bool KeepOtherFindings(const json& now, json* old) {
  if (TextOf(*old, "event") != "findings" || !old->value("photographs", json()).is_object())
    return true;
  json& left = old->at("photographs");
  if (TextOf(now, "event") == "photograph") left.erase(TextOf(now, "photograph"));
  if (TextOf(now, "event") != "findings") return !left.empty();
  const json told = now.value("photographs", json::object());
  for (const auto& [photograph, findings] : told.items()) left.erase(photograph);
  return !left.empty();
}

/// A command that skips the next one names it by the state that it came in, which is replaced.
void NameSkipped(const std::vector<json>& events, json* now) {
  if (!IsSkip(*now) || now->contains("id")) return;
  for (const json& event : events)
    if (TextOf(event, "event") == "state") (*now)["id"] = event.value("next", "");
}

}  // namespace

void KeepShootEvent(const std::string& line, std::vector<std::string>* events) {
  json now = json::parse(line);
  const std::string event = TextOf(now, "event");
  if (event == "live") return;
  // It has all photographs of its pose: what was before counts no more.
  if (event == "session") return events->assign(1, line);
  std::vector<json> before;
  for (const std::string& old : *events) before.push_back(json::parse(old));
  NameSkipped(before, &now);
  events->clear();
  for (json& old : before)
    if (!Replaces(now, old) && KeepOtherFindings(now, &old)) events->push_back(old.dump());
  events->push_back(now.dump());
}

}  // namespace keypose::studio
