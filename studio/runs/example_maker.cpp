#include "studio/runs/example_maker.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr auto kLook = std::chrono::milliseconds(100);
constexpr double kDrawn = 0.95;  // share of the work that is done when all is drawn

struct Recipe {
  std::vector<std::vector<std::string>> commands;  ///< first draws, the others are quick
  bool runs = false, has_films = false;
};

/// While it is made: a project is made of files that lie elsewhere, in an empty folder.
fs::path BesideIt(const fs::path& folder, const std::string& what) {
  return folder.parent_path() / ("." + folder.filename().string() + "." + what);
}

/// Small enough for some minutes on two cores, large enough for a good surface.
Recipe RecipeOf(const std::string& kind, const fs::path& folder) {
  const std::string drawn = BesideIt(folder, "drawn").string(), project = folder.string();
  const auto pose = [&](const std::string& name) { return name + "=" + drawn + "/photos/" + name; };
  const auto draw = [&](std::vector<std::string> more) {
    more.insert(more.begin() + 2, {"--output", drawn});
    return more;
  };
  const std::vector<std::string> init = {"keypose", "init", project};
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  if (kind == "two")
    return {{draw({"keypose-synth", "photos", "--poses", "rest,bent", "--views", "24", "--width",
                   "640"}),
             with(init, {"--pose", pose("rest"), "--pose", pose("bent"), "--template", "rest"})},
            false};
  if (kind == "film")
    return {{draw({"keypose-synth", "shot", "--few", "wave=8,bow=8", "--views", "24", "--width",
                   "640", "--photo-width", "640"}),
             with(init,
                  {"--pose", pose("rest"), "--pose", pose("wave"), "--pose", pose("bow"), "--film",
                   drawn + "/film", "--shows", "0=rest,4=wave,8=bow", "--film-fps", "12"})},
            false,
            true};
  if (kind == "dance")
    return {{draw({"keypose-synth", "performance", "--frames", "24", "--cameras", "6", "--size",
                   "480"}),
             with(init, {"--kind", "performance", "--shot", "walk=" + drawn + "/shot",
                         "--calibration", drawn + "/calibration.yml"})},
            false,
            true};
  if (kind == "puppet")
    return {{{"keypose-armature", "example", "--folder", (folder / "armature/example").string()}},
            false};
  return {{draw({"keypose-synth", "photos", "--poses", "rest,wave", "--few", "wave=6", "--views",
                 "24", "--width", "640"}),
           with(init, {"--pose", pose("rest"), "--pose", pose("wave"), "--template", "rest"})},
          kind == "finished"};
}

struct Said {
  int percent = 0;
  std::string words;
};

/// Of the last line such as "synth:  25 % photographs of rest".
Said LastSaid(const fs::path& file) {
  Said said;
  const std::string text = fs::exists(file) ? ReadFile(file) : "";
  const auto sign = text.rfind(" % ");
  if (sign == std::string::npos) return said;
  const auto end = text.find_first_of("\r\n", sign);
  said.words =
      WithoutOddBytes(text.substr(sign + 3, end == std::string::npos ? end : end - sign - 3));
  auto digits = sign;
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(text[digits - 1]))) --digits;
  if (sign > digits && sign - digits <= 3) said.percent = std::stoi(text.substr(digits));
  return said;
}

/// The drawn films become the project's own.
void TakeFilms(const fs::path& folder) {
  const fs::path drawn = BesideIt(folder, "drawn"), plan = folder / "pipeline.yaml";
  fs::rename(drawn, folder / "films");
  std::string text = ReadFile(plan);
  const std::string was = drawn.string();
  for (std::size_t at = 0; (at = text.find(was, at)) != std::string::npos;)
    text.replace(at, was.size(), "films");
  WriteFileAtomically(plan, text);
}

void RemoveAll(const fs::path& path) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

/// The folder for an example: not there yet, or empty.
void MakeFolder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    throw UsageError(fmt::format(
        "{} is there already; open it, or choose another place for the example", folder.string()));
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error))
    throw DiskError(fmt::format("cannot make the folder {}", folder.string()));
}

}  // namespace

const std::vector<std::string>& ExampleKinds() {
  static const std::vector<std::string> kKinds = {"finished", "two",   "six",
                                                  "film",     "dance", "puppet"};
  return kKinds;
}

ExampleMaker::ExampleMaker(fs::path programs, std::function<void(const fs::path&, bool)> made)
    : programs_(std::move(programs)), made_(std::move(made)) {}

ExampleMaker::~ExampleMaker() {
  stop_ = true;
  if (worker_.joinable()) worker_.join();
}

ExampleState ExampleMaker::State() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

void ExampleMaker::Set(const std::function<void(ExampleState&)>& change) {
  const std::lock_guard<std::mutex> lock(mutex_);
  change(state_);
}

void ExampleMaker::Start(const std::string& kind, const fs::path& base) {
  const auto& kinds = ExampleKinds();
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
    throw UsageError(fmt::format("there is no example '{}'", kind));
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_.at_work) throw LockedError("another example is being made; wait, or stop it");
  if (worker_.joinable()) worker_.join();
  const fs::path folder = base / kind;
  MakeFolder(folder);
  stop_ = false;
  state_ = {kind, folder, true, 0, "", ""};
  worker_ = std::thread([this, kind, folder] { Make(kind, folder); });
}

/// False: it has failed or was stopped, and the state says so.
bool ExampleMaker::Run(const std::vector<std::string>& command, const fs::path& folder, double from,
                       double to) {
  std::vector<std::string> words = command;
  words.front() = (programs_ / words.front()).string();
  const fs::path said = BesideIt(folder, "txt");
  const int pid = StartChild(words, folder, "/dev/null", said);
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(pid, &status, WNOHANG)) == 0 || (ended < 0 && errno == EINTR)) {
    if (stop_) kill(-pid, SIGTERM);
    const Said now = LastSaid(said);
    Set([&](ExampleState& state) {
      state.share = std::max(state.share, from + (to - from) * now.percent / 100);
      if (!now.words.empty()) state.words = now.words;
    });
    std::this_thread::sleep_for(kLook);
  }
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  const std::string error = code == 0 ? "" : WhatItSaid(said, code);
  RemoveAll(said);
  if (code == 0 && !stop_) return true;
  Set([&](ExampleState& state) { state.error = stop_ ? "stopped" : error; });
  return false;
}

void ExampleMaker::Make(const std::string& kind, const fs::path& folder) {
  const Recipe recipe = RecipeOf(kind, folder);
  bool good = true;
  RemoveAll(BesideIt(folder, "drawn"));  // of one that was given up
  try {
    for (std::size_t i = 0; good && i < recipe.commands.size(); ++i)
      good = Run(recipe.commands[i], folder, i == 0 ? 0 : kDrawn, i == 0 ? kDrawn : 1);
    // Photographs were copied; films are used where they are.
    if (good && recipe.has_films) TakeFilms(folder);
    if (good) made_(folder, recipe.runs);
  } catch (const std::exception& error) {
    good = false;
    Set([&](ExampleState& state) { state.error = error.what(); });
  }
  RemoveAll(BesideIt(folder, "drawn"));
  if (!good) RemoveAll(folder);
  Set([&](ExampleState& state) {
    state.at_work = false;
    if (good) state.share = 1;
  });
}

}  // namespace keypose::studio
