#include "studio/project/moves.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/graph/pipeline_edit.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

fs::path NotesOfMoves(const fs::path& project) { return project / ".keypose/studio/moves.json"; }

std::string NowOf(const fs::path& project) {
  return pipeline::RevisionOf(project / "pipeline.yaml");
}

/// Through links, too.
void RequireInside(const fs::path& project, const fs::path& path) {
  if (!StaysBelow(path.generic_string()) ||
      !IsWithin(fs::weakly_canonical((project / path).parent_path()), fs::canonical(project)))
    throw UsageError(fmt::format("{} is outside of the project", path.generic_string()));
}

}  // namespace

Moves::Moves(fs::path project) : project_(std::move(project)) {}

Moves::~Moves() { PutBack(); }

void Moves::Do(const fs::path& from, const fs::path& to) {
  RequireInside(project_, from);
  RequireInside(project_, to);
  if (fs::exists(fs::symlink_status(project_ / to)))
    throw UsageError(fmt::format("there is a {} already; move it away first", to.generic_string()));
  done_.emplace_back(from, to);
  Note();
  std::error_code error;
  fs::create_directories((project_ / to).parent_path(), error);
  if (!error) fs::rename(project_ / from, project_ / to, error);
  if (!error) return;
  done_.pop_back();
  throw DiskError(fmt::format("cannot move {} to {}: {}", from.generic_string(),
                              to.generic_string(), error.message()));
}

void Moves::Keep() {
  done_.clear();
  std::error_code ignored;
  fs::remove(NotesOfMoves(project_), ignored);
}

/// Written before a move, so that the notes never lack one.
void Moves::Note() const {
  json moves = json::array();
  for (const auto& [from, to] : done_)
    moves.push_back({from.generic_string(), to.generic_string()});
  fs::create_directories(NotesOfMoves(project_).parent_path());
  WriteFileAtomically(NotesOfMoves(project_),
                      json{{"revision", NowOf(project_)}, {"moves", moves}}.dump());
}

void Moves::PutBack() {
  std::error_code ignored;
  for (auto move = done_.rbegin(); move != done_.rend(); ++move)
    fs::rename(project_ / move->second, project_ / move->first, ignored);
  Keep();
}

void UndoBrokenMoves(const fs::path& project) {
  const fs::path file = NotesOfMoves(project);
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return;
  const std::string text = ReadFile(file);
  const json notes = IsShallowJson(text) ? json::parse(text, nullptr, false) : json();
  // Another pipeline.yaml tells of the moves: they were whole.
  const bool whole = !notes.is_object() || notes.value("revision", "") != NowOf(project);
  if (!whole) {
    const json moves = notes.value("moves", json::array());
    for (auto move = moves.rbegin(); move != moves.rend(); ++move) {
      const std::string from = move->at(0), to = move->at(1);
      if (!StaysBelow(from) || !StaysBelow(to)) continue;
      if (!fs::exists(project / from, ignored)) fs::rename(project / to, project / from, ignored);
    }
  }
  fs::remove(file, ignored);
}

}  // namespace keypose::studio
