#include "studio/http/session_answers.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"

namespace keypose::studio {

using nlohmann::json;

json StoryJson(const SessionState& story) {
  json events = json::array();
  for (const std::string& line : story.events) events.push_back(json::parse(line));
  return {{"running", story.running},
          {"number", story.number},
          {"events", events},
          {"exit_code", story.exit_code},
          {"message", story.message}};
}

SessionListener ToPages(EventHub& hub, const std::string& name) {
  SessionListener listener;
  listener.event = [&hub, name](std::uint64_t number, const std::string& event) {
    hub.Send(name, fmt::format("{{\"number\": {}, \"event\": {}}}", number, event));
  };
  listener.ended = [&hub, name](std::uint64_t number, int code, const std::string& message) {
    hub.Send(name + "_ended",
             json{{"number", number}, {"exit_code", code}, {"message", message}}.dump());
  };
  return listener;
}

json SavedJson(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return nullptr;
  const json saved = json::parse(ReadFile(file), nullptr, false);
  return saved.is_object() ? saved : json();
}

}  // namespace keypose::studio
