#include "core/stage/output_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::internal {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* kMark = ".keypose-made.json";

/// The path with links resolved, as far as it exists.
fs::path Resolved(const fs::path& path) {
  std::error_code error;
  fs::path resolved = fs::weakly_canonical(fs::absolute(path), error);
  if (error) resolved = fs::absolute(path).lexically_normal();
  return resolved.has_filename() ? resolved : resolved.parent_path();
}

const Port& PortOf(const StageSpec& spec, const std::string& name) {
  return *std::find_if(spec.outputs.begin(), spec.outputs.end(),
                       [&](const Port& port) { return port.name == name; });
}

json StampOf(const fs::directory_entry& entry) {
  using std::chrono::duration_cast, std::chrono::nanoseconds;
  return {entry.file_size(),
          duration_cast<nanoseconds>(entry.last_write_time().time_since_epoch()).count()};
}

json FilesOf(const fs::path& folder) {
  json files = json::object();
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (entry.is_regular_file() && !entry.is_symlink() && name != kMark)
      files[name] = StampOf(entry);
  }
  return files;
}

/// The first file of a folder that the stage did not write, or that was changed since. Empty when
/// there is none.
std::string ForeignFile(const fs::path& folder, const std::string& stage) {
  const fs::path mark = folder / kMark;
  const json made =
      fs::is_regular_file(mark) ? json::parse(ReadFile(mark), nullptr, false) : json();
  const bool own = made.is_object() && made.value("stage", json()) == stage &&
                   made.contains("files") && made["files"].is_object();
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    if (name == kMark || (own && entry.is_directory() && !entry.is_symlink())) continue;
    const bool as_written = own && entry.is_regular_file() && !entry.is_symlink() &&
                            made["files"].contains(name) && made["files"][name] == StampOf(entry);
    if (!as_written) return name;
  }
  return {};
}

[[noreturn]] void Refuse(const StageSpec& spec, const fs::path& place, const std::string& why) {
  throw DiskError(fmt::format("{}: the output {} {}", spec.name, place.string(), why));
}

/// Refuses what even --overwrite does not allow.
void CheckAgainstInputs(const StageSpec& spec, const fs::path& place, bool is_folder,
                        const PortPaths& inputs) {
  const fs::path resolved = Resolved(place);
  for (const auto& [port, paths] : inputs)
    for (const fs::path& path : paths) {
      const fs::path input = Resolved(path);
      if (resolved == input)
        Refuse(spec, place,
               fmt::format("is the input --{} as well, which would be lost; name another place",
                           port));
      if (!is_folder) continue;
      if (IsWithin(input, resolved))
        Refuse(spec, place,
               fmt::format("holds the input --{} {}, which would be lost; name a folder of its own",
                           port, path.string()));
    }
  if (!is_folder || !fs::exists(place)) return;
  const char* home = std::getenv("HOME");
  if (IsWithin(Resolved(fs::current_path()), resolved))
    Refuse(spec, place,
           "is the working folder or lies above it, and all that is in it would be lost; name a "
           "folder of its own");
  if (home && *home && IsWithin(Resolved(home), resolved))
    Refuse(spec, place, "is the home folder or lies above it; name a folder of its own");
}

/// Refuses folders that are part of an input folder, unless this stage wrote them.
void CheckNotPartOfInput(const StageSpec& spec, const fs::path& place, const PortPaths& inputs) {
  if (!fs::exists(place) || ForeignFile(place, spec.name).empty()) return;
  for (const auto& [port, paths] : inputs)
    for (const fs::path& path : paths)
      if (IsWithin(Resolved(place), Resolved(path)))
        Refuse(spec, place,
               fmt::format("is a part of the input --{} {}; name a folder outside of it", port,
                           path.string()));
}

struct Output {
  std::string port;
  fs::path place;
  bool folder = false;
};

void CheckAgainstEachOther(const std::vector<Output>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i)
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      const fs::path a = Resolved(outputs[i].place), b = Resolved(outputs[k].place);
      if (i < k && a == b)
        throw UsageError(fmt::format("--{} and --{} have the same place, {}; give each its own",
                                     outputs[i].port, outputs[k].port, a.string()));
      if (i != k && outputs[i].folder && IsWithin(b, a))
        throw UsageError(
            fmt::format("--{} {} lies in the folder of --{}, which is replaced as a whole; give "
                        "each its own place",
                        outputs[k].port, b.string(), outputs[i].port));
    }
}

}  // namespace

fs::path PlaceOf(const fs::path& given, bool is_folder) {
  if (is_folder) return Resolved(given);
  const fs::path place = fs::absolute(given).lexically_normal();
  return place.has_filename() ? place : place.parent_path();
}

void CheckPlace(const StageSpec& spec, const fs::path& place, bool is_folder, bool overwrite) {
  if (!fs::exists(place)) return;
  if (!is_folder) {
    if (fs::is_directory(place))
      Refuse(spec, place, "is a folder, but a file goes there; name a file in it");
    if (!fs::is_regular_file(place)) Refuse(spec, place, "is not a regular file; name a file");
    return;
  }
  if (!fs::is_directory(place))
    Refuse(spec, place, "is a file, but a folder goes there; name a folder");
  const std::string foreign = ForeignFile(place, spec.name);
  if (!foreign.empty() && !overwrite)
    Refuse(spec, place,
           fmt::format(
               "exists and holds files that this stage did not write, or that were changed since "
               "({}); name a folder that is empty or does not exist, or "
               "use --overwrite to replace it and everything in it",
               foreign));
}

void CheckOutputs(const StageSpec& spec, const PortPaths& inputs, const PortPaths& outputs,
                  const fs::path& report, bool overwrite) {
  std::vector<Output> all;
  for (const auto& [port, paths] : outputs) {
    const bool is_folder = PortOf(spec, port).kind == "folder";
    all.push_back({port, PlaceOf(paths.front(), is_folder), is_folder});
  }
  CheckAgainstEachOther(all);
  for (const Output& output : all) {
    if (!PortOf(spec, output.port).in_place)
      CheckAgainstInputs(spec, output.place, output.folder, inputs);
    if (output.folder) CheckNotPartOfInput(spec, output.place, inputs);
    CheckPlace(spec, output.place, output.folder, overwrite);
  }
  if (report.empty()) return;
  CheckAgainstInputs(spec, PlaceOf(report, false), false, inputs);
  if (fs::is_directory(report))
    Refuse(spec, report, "is a folder, but --report writes a file; name a file in it");
}

void MarkFolder(const fs::path& folder, const std::string& stage) {
  WriteFile(folder / kMark,
            json{{"schema", 1}, {"stage", stage}, {"files", FilesOf(folder)}}.dump(1) + "\n");
}

}  // namespace keypose::internal
