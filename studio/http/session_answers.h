// What pages are told of a session: its story when they ask, its events as they come.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/http/event_hub.h"
#include "studio/runs/session_relay.h"

namespace keypose::studio {

/// {"running", "number", "events", "exit_code", "message"}
nlohmann::json StoryJson(const SessionState& story);
/// Sends events as NAME, and the session's end as NAME_ended.
SessionListener ToPages(EventHub& hub, const std::string& name);
/// The object that a file of the studio's own holds; null without one.
nlohmann::json SavedJson(const std::filesystem::path& file);

}  // namespace keypose::studio
