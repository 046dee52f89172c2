// Files of a project that change their places together, or not at all.
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

namespace keypose::studio {

/// Moves files and folders. Unless they are kept, the end of this object puts all back. What the
/// end of the program breaks off is put back by UndoBrokenMoves.
class Moves {
 public:
  explicit Moves(std::filesystem::path project);
  ~Moves();
  Moves(const Moves&) = delete;
  Moves& operator=(const Moves&) = delete;

  /// @param from, to  relative to the project; folders on the way to `to` are made
  /// @throws UsageError  `to` is there already, or one of the two is outside of the project
  /// @throws DiskError
  void Do(const std::filesystem::path& from, const std::filesystem::path& to);
  /// They stay. To be said after pipeline.yaml, which tells of them, is written.
  void Keep();

 private:
  void Note() const;
  void PutBack();

  std::filesystem::path project_;
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> done_;
};

/// Puts back what was moved when the program ended in the middle of it.
void UndoBrokenMoves(const std::filesystem::path& project);

}  // namespace keypose::studio
