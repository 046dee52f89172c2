#include "studio/runs/armature_control.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A hand does not move faster than a page can show.
constexpr int kReadings = 60, kPoses = 30;

/// --NAME=VALUE in one word, so that no value can be taken for another flag.
void AddWord(const char* name, const std::string& value, std::vector<std::string>* words) {
  if (!value.empty()) words->push_back(fmt::format("--{}={}", name, value));
}

std::vector<std::string> LiveWords(const ArmatureSetup& setup, const fs::path& page,
                                   const fs::path& take) {
  std::vector<std::string> words = {ArmatureProgram().string(), "live"};
  AddWord("description", setup.description, &words);
  AddWord("chains", setup.chains, &words);
  AddWord("skeleton", setup.skeleton, &words);
  AddWord("armature_up", setup.armature_up, &words);
  AddWord("skeleton_up", setup.skeleton_up, &words);
  AddWord("mesh", setup.mesh, &words);
  AddWord("weights", setup.weights, &words);
  AddWord("plate", setup.plate, &words);
  AddWord("shot", setup.shot, &words);
  AddWord("port", setup.port, &words);
  if (setup.port == "simulated") AddWord("simulated", "frames", &words);
  AddWord("calibration", setup.calibration, &words);
  AddWord("fps", fmt::format("{}", setup.fps), &words);
  AddWord("step", fmt::format("{}", setup.step), &words);
  AddWord("rate", fmt::format("{}", kReadings), &words);
  AddWord("page_rate", fmt::format("{}", kPoses), &words);
  AddWord("page", page.string(), &words);
  AddWord("session", take.string(), &words);
  return words;
}

std::vector<std::string> BakeWords(const ArmatureSetup& setup, const fs::path& take,
                                   const std::string& between) {
  std::vector<std::string> words = {ArmatureProgram().string(), "bake", "--overwrite"};
  AddPuppetFiles(setup, true, &words);
  AddFlag("curves", (take / "curves.json").string(), &words);
  AddFlag("between", between, &words);
  const bool keys = between == "keys";
  AddFlag("frames", (take / (keys ? "keys" : "frames")).string(), &words);
  AddFlag(keys ? "timeline" : "motion", (take / (keys ? "timeline.json" : "motion.bvh")).string(),
          &words);
  return words;
}

bool HasEvent(const std::string& line) {
  const json told = json::parse(line, nullptr, false);
  return told.is_object() && told.contains("event") && told["event"].is_string();
}

/// What an event is about: the next one about the same takes its place.
std::string SubjectOf(const std::string& line) {
  const json told = json::parse(line);
  const std::string event = told.at("event");
  for (const char* of_box : {"cable-out", "cable-back", "silent", "power-lost"})
    if (event == of_box) return "controller";
  const json joint = told.value("joint", json());
  return joint.is_string() ? "joint " + joint.get<std::string>() : event;
}

/// A loose plug tells of itself many times a second, and must not push out how the session began.
void KeepArmatureEvent(const std::string& event, std::vector<std::string>* events) {
  const std::string subject = SubjectOf(event);
  std::erase_if(*events, [&](const std::string& old) { return SubjectOf(old) == subject; });
  events->push_back(event);
}

}  // namespace

fs::path ArmatureProgram() { return pipeline::ProgramFolder() / "keypose-armature"; }

void AddFlag(const char* name, const std::string& value, std::vector<std::string>* words) {
  if (!value.empty()) words->insert(words->end(), {std::string("--") + name, value});
}

void AddPuppetFiles(const ArmatureSetup& setup, bool with_mesh, std::vector<std::string>* words) {
  AddFlag("description", setup.description, words);
  AddFlag("chains", setup.chains, words);
  AddFlag("skeleton", setup.skeleton, words);
  AddFlag("armature_up", setup.armature_up, words);
  AddFlag("skeleton_up", setup.skeleton_up, words);
  if (!with_mesh) return;
  AddFlag("mesh", setup.mesh, words);
  AddFlag("weights", setup.weights, words);
}

ArmatureControl::ArmatureControl(fs::path project, Listener listener)
    : project_(std::move(project)),
      listener_(std::move(listener)),
      relay_({[this](const std::string& line) { return !TakePose(line) && HasEvent(line); },
              KeepArmatureEvent, "end"},
             Followed(listener_)) {}

ArmatureControl::~ArmatureControl() {
  leave_ = true;
  posed_.notify_all();
  if (bake_.joinable()) bake_.join();
  if (baker_) baker_->Interrupt();
}

/// Who waits for a pose learns that the session has ended.
SessionListener ArmatureControl::Followed(const SessionListener& listener) {
  SessionListener followed = listener;
  followed.event = [this, event = listener.event](std::uint64_t number, const std::string& line) {
    if (SubjectOf(line) == "session") {
      std::unique_lock<std::mutex> lock(mutex_);
      const ArmatureSetup setup = setup_;
      lock.unlock();
      listener_.began(setup);
    }
    event(number, line);
  };
  followed.ended = [this, ended = listener.ended](std::uint64_t number, int code,
                                                  const std::string& message) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      pose_.clear();
    }
    posed_.notify_all();
    ended(number, code, message);
  };
  return followed;
}

fs::path ArmatureControl::TakeFolder(const std::string& take) const {
  return project_ / "armature" / take;
}

void ArmatureControl::Start(const ArmatureSetup& setup) {
  const auto prepare = [&] {
    fs::create_directories(project_ / "armature");
    const std::lock_guard<std::mutex> lock(mutex_);
    setup_ = setup;
  };
  relay_.Start(LiveWords(setup, PageFolder(), TakeFolder(setup.take)), project_,
               PageFolder() / "live.txt", prepare, "");
}

ArmatureState ArmatureControl::State() const {
  ArmatureState state{relay_.State()};
  const std::lock_guard<std::mutex> lock(mutex_);
  state.baking = baking_;
  return state;
}

std::string ArmatureControl::Pose(std::uint64_t after) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto is_new = [&] { return !pose_.empty() && pose_number_ != after; };
  posed_.wait_for(lock, std::chrono::seconds(1),
                  [&] { return leave_ || !relay_.running() || is_new(); });
  if (!relay_.running() || !is_new()) return "";
  return fmt::format("{{\"number\": {}, \"pose\": {}}}", pose_number_, pose_);
}

/// Keeps a line that is a pose.
bool ArmatureControl::TakePose(const std::string& line) {
  const json told = json::parse(line, nullptr, false);
  if (!told.is_object() || !told.contains("pose")) return false;
  const std::lock_guard<std::mutex> lock(mutex_);
  pose_ = line;
  ++pose_number_;
  posed_.notify_all();
  return true;
}

void ArmatureControl::Bake(const ArmatureSetup& setup, const std::string& between) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (baking_) throw LockedError("frames are baked already; wait for them");
  if (bake_.joinable()) bake_.join();
  fs::create_directories(PageFolder());
  baker_ = std::make_unique<TalkingChild>(BakeWords(setup, TakeFolder(setup.take), between),
                                          project_, PageFolder() / "bake.txt");
  baking_ = true;
  bake_ = std::thread([this] { FollowBake(); });
}

void ArmatureControl::FollowBake() {
  std::string line;
  TalkingChild::Heard heard = TalkingChild::Heard::kNothing;
  while (!leave_ && heard != TalkingChild::Heard::kEnd) heard = baker_->Hear(&line);
  if (heard != TalkingChild::Heard::kEnd) return;
  const int code = baker_->Wait();
  const fs::path log = PageFolder() / "bake.txt";
  const std::string said = WhatItSaid(log, code), told = code == 0 ? WarningsIn(said) : said;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    baking_ = false;
  }
  listener_.baked(code, told);
}

}  // namespace keypose::studio
