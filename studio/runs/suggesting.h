// Pairs of places that look alike on two meshes, from `keypose landmarks suggest`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::studio {

struct SuggestQuestion {
  std::filesystem::path source, target;
  std::vector<std::filesystem::path> known;  ///< pairs, or picks of both; they are kept
  int count = 12;                            ///< 1 to 100
};

/// The file of pairs, which is gone with this: two tabs may ask at once.
class Suggested {
 public:
  /// @param folder  of the project
  /// @throws UsageError  a count that there is not @throws InputError  as the program said
  Suggested(const std::filesystem::path& folder, const SuggestQuestion& question);
  ~Suggested();
  Suggested(const Suggested&) = delete;
  Suggested& operator=(const Suggested&) = delete;

  const std::filesystem::path& file() const { return file_; }
  /// Where it has found none, and the file may have no pair: why, and what to do; else "".
  const std::string& why_none() const { return why_none_; }

 private:
  std::filesystem::path file_, report_;
  std::string why_none_;
};

}  // namespace keypose::studio
