#include "studio/runs/take_editor.h"

#include <fmt/format.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kPatience_s = 120;

/// A folder that is gone afterwards.
class ScratchFolder {
 public:
  explicit ScratchFolder(fs::path folder) : folder_(std::move(folder)) {
    fs::create_directories(folder_);
  }
  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(folder_, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return folder_; }

 private:
  fs::path folder_;
};

void Without(const std::string& piece, std::string* text) {
  for (auto at = text->find(piece); at != std::string::npos; at = text->find(piece))
    text->erase(at, piece.size());
}

/// Differs when a file that the character is made of does, or the project was moved: view.json
/// names plates by where they are.
std::string StampOf(const fs::path& project, const ArmatureSetup& setup) {
  std::string stamp = project.string() + "\n" + setup.armature_up + setup.skeleton_up + "\n";
  for (const std::string& name : {setup.description, setup.chains, setup.skeleton, setup.mesh,
                                  setup.weights, setup.plate, setup.shot}) {
    std::error_code error;
    const fs::path file = project / name;
    const auto written = fs::last_write_time(file, error).time_since_epoch().count();
    const auto size = fs::is_directory(file, error) ? 0 : fs::file_size(file, error);
    stamp += fmt::format("{}\n{} {}\n", name, name.empty() ? 0 : written, name.empty() ? 0 : size);
  }
  return stamp;
}

std::string EditText(const EditLines& edits) {
  std::string text;
  for (const std::string& line : edits) text += line + "\n";
  return text;
}

}  // namespace

TakeEditor::TakeEditor(fs::path project) : project_(std::move(project)) {}

fs::path TakeEditor::CharacterFolder(const std::string& take) const {
  return project_ / ".keypose/studio/takes" / take;
}

fs::path TakeEditor::Curves(const ArmatureSetup& setup) const {
  return project_ / "armature" / setup.take / "curves.json";
}

void TakeEditor::Run(const std::vector<std::string>& words, const fs::path& scratch) const {
  const ChildResult result = RunChild(words, project_, kPatience_s);
  if (result.exit_code == 0) return;
  if (result.exit_code == 124)
    throw UsageError("it was not ready within two minutes; is the mesh very large?");
  std::string said = ErrorIn(result.output, result.exit_code);
  // Nobody but this program knows where the edits were for a moment.
  Without(scratch.string() + "/", &said);
  throw UsageError(said);
}

fs::path TakeEditor::NewScratch() {
  return project_ / ".keypose/studio/take-drafts" / fmt::format("{}-{}", ::getpid(), ++scratches_);
}

void TakeEditor::MakeCharacter(const ArmatureSetup& setup) {
  const std::lock_guard<std::mutex> lock(characters_);
  const fs::path folder = CharacterFolder(setup.take), stamp = folder / "stamp.txt";
  const std::string wanted = StampOf(project_, setup);
  if (fs::is_regular_file(stamp) && ReadFile(stamp) == wanted) return;
  std::vector<std::string> words = {ArmatureProgram().string(), "show", "--overwrite"};
  AddPuppetFiles(setup, true, &words);
  AddFlag("plate", setup.plate, &words);
  AddFlag("shot", setup.shot, &words);
  AddFlag("page", folder.string(), &words);
  Run(words, folder);
  WriteFileAtomically(stamp, wanted);
}

/// One that is at work for this take already goes on.
void TakeEditor::StartDrafter(const ArmatureSetup& setup) {
  const std::string stamp = setup.take + "\n" + StampOf(project_, setup);
  if (drafter_ && stamp == drafter_stamp_) return;
  std::vector<std::string> words = {ArmatureProgram().string(), "drafts"};
  AddPuppetFiles(setup, false, &words);
  AddFlag("curves", Curves(setup).string(), &words);
  drafter_ = std::make_unique<TalkingChild>(words, project_,
                                            project_ / ".keypose/studio/take-drafts/said.txt");
  drafter_stamp_ = stamp;
}

std::string TakeEditor::Ask(const std::string& question) {
  drafter_->Say(question);
  std::string answer;
  for (int i = 0; i < 10 * kPatience_s; ++i) {
    const TalkingChild::Heard heard = drafter_->Hear(&answer);
    if (heard == TalkingChild::Heard::kLine) return answer;
    if (heard == TalkingChild::Heard::kEnd) {
      const int code = drafter_->Wait();
      drafter_.reset();
      throw UsageError(WhatItSaid(project_ / ".keypose/studio/take-drafts/said.txt", code));
    }
  }
  drafter_->Interrupt();
  drafter_.reset();
  throw UsageError("the take was not ready within two minutes; it may be too long to change here");
}

std::string TakeEditor::Draft(const ArmatureSetup& setup, const EditLines& edits,
                              const std::string& between) {
  const ScratchFolder scratch(NewScratch());
  const fs::path file = scratch.path() / "edits.txt", to = scratch.path() / "draft.bin";
  if (!edits.empty()) WriteFile(file, EditText(edits));
  const json question = {
      {"edits", edits.empty() ? "" : file.string()}, {"to", to.string()}, {"between", between}};
  const std::lock_guard<std::mutex> lock(drafts_);
  StartDrafter(setup);
  const json answer = json::parse(Ask(question.dump()), nullptr, false);
  if (answer.is_object() && answer.contains("error"))
    throw UsageError(answer.at("error").get<std::string>());
  return ReadFile(to);
}

void TakeEditor::Save(const ArmatureSetup& setup, const EditLines& edits, const std::string& name) {
  const ScratchFolder scratch(NewScratch());
  const fs::path file = scratch.path() / "edits.txt";
  WriteFile(file, EditText(edits) + fmt::format("# of the take {}\n", setup.take));
  std::vector<std::string> words = {ArmatureProgram().string(), "edit"};
  AddFlag("description", setup.description, &words);
  AddFlag("curves", Curves(setup).string(), &words);
  AddFlag("edits", file.string(), &words);
  AddFlag("take", (project_ / "armature" / name).string(), &words);
  Run(words, scratch.path());
}

}  // namespace keypose::studio
