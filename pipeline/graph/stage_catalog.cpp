#include "pipeline/graph/stage_catalog.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "pipeline/graph/stamp_json.h"

namespace keypose::pipeline {

using nlohmann::json;

struct CatalogMemory {
  json entries = json::object();
};

StageCatalog::StageCatalog(Disk& disk, ProcessRunner& processes, std::filesystem::path memory_file,
                           std::filesystem::path shared_file)
    : disk_(disk),
      processes_(processes),
      memory_file_(std::move(memory_file)),
      shared_file_(std::move(shared_file)) {}

namespace {

/// By path. A tool that is not installed has its name instead of a path.
json StampsOf(const std::map<std::string, std::optional<FileStat>>& programs) {
  json stamps = json::object();
  for (const auto& [path, stat] : programs) stamps[path] = stat ? StampOf(*stat) : json();
  return stamps;
}

std::vector<std::string> ToolsOf(const StageInfo& info) {
  std::vector<std::string> tools;
  for (const auto& [tool, version] : info.tools) tools.push_back(tool);
  return tools;
}

}  // namespace

std::map<std::string, std::optional<FileStat>> StageCatalog::ProgramsOf(
    const std::string& program, const std::vector<std::string>& tools) const {
  std::map<std::string, std::optional<FileStat>> programs = {{program, disk_.Stat(program)}};
  for (const std::string& tool : tools) {
    const auto path = processes_.FindTool(tool);
    programs[path ? path->string() : tool] = path ? disk_.Stat(*path) : std::nullopt;
  }
  return programs;
}

bool StageCatalog::Recall(const std::string& program, const CatalogMemory& memory) {
  const auto entry = memory.entries.find(program);
  if (entry == memory.entries.end() || !entry->is_object()) return false;
  try {
    StageInfo info = ParseStageInfo(entry->at("describe").get<std::string>(), program);
    info.programs = ProgramsOf(program, ToolsOf(info));
    if (entry->at("stamps") != StampsOf(info.programs)) return false;
    stages_[program] = std::move(info);
    return true;
  } catch (const json::exception&) {
    return false;
  } catch (const ToolError&) {
    return false;  // damaged: the program is run again
  }
}

void StageCatalog::Learn(const std::string& program, const std::optional<FileStat>& before,
                         const ProcessRunner::Answer& answer, CatalogMemory& memory) {
  if (answer.exit_code != 0) {
    throw ToolError(
        fmt::format("{} --describe ended with exit code {}: {}\nis it an executable that follows "
                    "docs/stage-contract.md?",
                    program, answer.exit_code, answer.error));
  }
  StageInfo& info = stages_[program] = ParseStageInfo(answer.output, program);
  info.programs = ProgramsOf(program, ToolsOf(info));
  if (info.programs.at(program) != before)
    throw ToolError(
        program +
        " was replaced while its --describe ran; run again when its installation has ended");
  memory.entries[program] = {{"stamps", StampsOf(info.programs)}, {"describe", answer.output}};
}

CatalogMemory StageCatalog::Remembered(const std::filesystem::path& file) const {
  CatalogMemory memory;
  try {
    if (!file.empty() && disk_.Stat(file))
      memory.entries = json::parse(disk_.Read(file), nullptr, false);
  } catch (const DiskError&) {
    // As if there were none.
  }
  if (!memory.entries.is_object()) memory.entries = json::object();
  return memory;
}

void StageCatalog::Remember(const std::filesystem::path& file, const CatalogMemory& memory) {
  if (file.empty()) return;
  try {
    disk_.Write(file, memory.entries.dump(0));
  } catch (const DiskError&) {
    // Not an error: if this cannot be saved (full or read-only disk), the programs are run again
    // next time.
  }
}

void StageCatalog::Ask(const std::vector<std::string>& programs, CatalogMemory& memory) {
  std::vector<std::vector<std::string>> questions;
  for (const std::string& program : programs) questions.push_back({program, "--describe"});
  asked_ += SizeOf(programs);
  std::vector<std::optional<FileStat>> before;
  for (const std::string& program : programs) before.push_back(disk_.Stat(program));
  const auto answers = processes_.Ask(questions);
  if (processes_.interrupted()) throw Cancelled();
  for (std::size_t i = 0; i < programs.size(); ++i)
    Learn(programs[i], before[i], answers[i], memory);
}

void StageCatalog::Share(const std::vector<std::string>& programs, const CatalogMemory& memory) {
  if (shared_file_.empty() || programs.empty()) return;
  CatalogMemory shared = Remembered(shared_file_);
  for (const std::string& program : programs) shared.entries[program] = memory.entries.at(program);
  CatalogMemory kept;
  for (const auto& [program, entry] : shared.entries.items())
    if (disk_.Stat(program)) kept.entries[program] = entry;
  Remember(shared_file_, kept);
}

void StageCatalog::Load(const std::vector<std::filesystem::path>& programs) {
  CatalogMemory memory = Remembered(memory_file_);
  std::vector<std::string> elsewhere, unknown;
  for (const auto& program : programs) {
    if (!stages_.contains(program.string()) && !Recall(program.string(), memory))
      elsewhere.push_back(program.string());
  }
  if (elsewhere.empty()) return;
  const CatalogMemory shared = Remembered(shared_file_);
  for (const std::string& program : elsewhere) {
    if (Recall(program, shared))
      memory.entries[program] = shared.entries.at(program);
    else
      unknown.push_back(program);
  }
  if (!unknown.empty()) Ask(unknown, memory);
  Remember(memory_file_, memory);
  Share(unknown, memory);
}

const StageInfo& StageCatalog::Get(const std::filesystem::path& program) const {
  return stages_.at(program.string());
}

}  // namespace keypose::pipeline
