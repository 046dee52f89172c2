#include "pipeline/stage_catalog.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/errors.h"

namespace keypose::pipeline {

using nlohmann::json;

struct CatalogMemory {
  json entries = json::object();
};

StageCatalog::StageCatalog(Disk& disk, ProcessRunner& processes, std::filesystem::path memory_file)
    : disk_(disk), processes_(processes), memory_file_(std::move(memory_file)) {}

std::string StageCatalog::Stamp(const std::filesystem::path& path) const {
  const auto stat = disk_.Stat(path);
  return stat ? fmt::format("{} {} {} {}", path.string(), stat->size, stat->mtime_ns, stat->inode) : "none";
}

bool StageCatalog::Recall(const std::string& program, const CatalogMemory& memory) {
  const auto entry = memory.entries.find(program);
  if (entry == memory.entries.end() || entry->value("stamp", "") != Stamp(program)) return false;
  const json tools = entry->value("tools", json::object());
  for (const auto& [tool, stamp] : tools.items()) {
    const auto path = processes_.FindTool(tool);
    if (stamp != (path ? Stamp(*path) : "none")) return false;
  }
  stages_[program] = ParseStageInfo(entry->value("describe", ""), program);
  return true;
}

void StageCatalog::Load(const std::vector<std::filesystem::path>& programs) {
  CatalogMemory memory;
  if (!memory_file_.empty() && disk_.Stat(memory_file_)) {
    memory.entries = json::parse(disk_.Read(memory_file_), nullptr, false);
    if (!memory.entries.is_object()) memory.entries = json::object();
  }
  std::vector<std::string> unknown;
  for (const auto& program : programs) {
    if (!stages_.contains(program.string()) && !Recall(program.string(), memory)) unknown.push_back(program.string());
  }
  if (unknown.empty()) return;
  std::vector<std::vector<std::string>> questions;
  for (const std::string& program : unknown) questions.push_back({program, "--describe"});
  asked_ += static_cast<int>(unknown.size());
  const auto answers = processes_.Ask(questions);
  if (processes_.interrupted()) throw Cancelled();
  for (std::size_t i = 0; i < unknown.size(); ++i) {
    if (answers[i].exit_code != 0) {
      throw ToolError(fmt::format("{} --describe ended with exit code {}: {}\nis it an executable that follows docs/stage-contract.md?",
                                  unknown[i], answers[i].exit_code, answers[i].error));
    }
    stages_[unknown[i]] = ParseStageInfo(answers[i].output, unknown[i]);
    json tools = json::object();
    for (const auto& [tool, version] : stages_[unknown[i]].tools) {
      const auto path = processes_.FindTool(tool);
      tools[tool] = path ? Stamp(*path) : "none";
    }
    memory.entries[unknown[i]] = {{"stamp", Stamp(unknown[i])}, {"tools", tools}, {"describe", answers[i].output}};
  }
  try {
    if (!memory_file_.empty()) disk_.Write(memory_file_, memory.entries.dump(0));
  } catch (const DiskError&) {
    // Only a memory: on a full or read-only disk the programs are asked again next time.
  }
}

const StageInfo& StageCatalog::Get(const std::filesystem::path& program) const { return stages_.at(program.string()); }

}  // namespace keypose::pipeline
