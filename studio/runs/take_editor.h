// A recorded take on its page: its character (`keypose armature show`), the take as changes would
// make it (`keypose armature drafts`, which stays as long as a take is looked at), and changes that
// are kept as a new take (`keypose armature edit`).
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "studio/runs/armature_control.h"

namespace keypose::studio {

/// Lines of a file of edits (docs/stages/armature.md), without their ends.
using EditLines = std::vector<std::string>;

class TakeEditor {
 public:
  explicit TakeEditor(std::filesystem::path project);

  /// Where the character of a take is: view.json, weights.bin, rest.ply.
  std::filesystem::path CharacterFolder(const std::string& take) const;

  /// Makes the character's files, if those that it is made of have changed.
  /// @throws UsageError  in the program's words
  void MakeCharacter(const ArmatureSetup& setup);

  /// The take as the edits change it: a line of JSON, {"fps", "step", "film", "joints": [{"name",
  /// "unit", "low", "high", "values"}, ...]}, filled up to a multiple of four bytes, then the bones
  /// in each recorded frame as in frames.bin of `live --page`; then the bones in each of the `film`
  /// frames that a bake would make, and their joints' values, frame after frame (float32).
  /// @param between  "linear" or "smooth": as baked so; "": no film
  /// @throws UsageError  in the program's words: an edit that cannot be done, with its line
  std::string Draft(const ArmatureSetup& setup, const EditLines& edits, const std::string& between);

  /// Keeps the changed take as `armature/NAME`. @pre there is no such folder
  /// @throws UsageError  in the program's words
  void Save(const ArmatureSetup& setup, const EditLines& edits, const std::string& name);

 private:
  std::filesystem::path Curves(const ArmatureSetup& setup) const;
  std::filesystem::path NewScratch();
  void Run(const std::vector<std::string>& words, const std::filesystem::path& scratch) const;
  void StartDrafter(const ArmatureSetup& setup);
  std::string Ask(const std::string& question);

  const std::filesystem::path project_;
  std::mutex characters_;
  std::mutex drafts_;  ///< of what follows
  std::unique_ptr<TalkingChild> drafter_;
  std::string drafter_stamp_;  ///< with which take and files it was started
  std::atomic<unsigned> scratches_ = 0;
};

}  // namespace keypose::studio
