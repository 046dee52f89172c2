#include "pipeline/stage_catalog.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/size_of.h"
#include "pipeline/stamp_json.h"

namespace keypose::pipeline {

using nlohmann::json;

struct CatalogMemory {
  json entries = json::object();
};

StageCatalog::StageCatalog(Disk& disk, ProcessRunner& processes, std::filesystem::path memory_file)
    : disk_(disk), processes_(processes), memory_file_(std::move(memory_file)) {}

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

void StageCatalog::Load(const std::vector<std::filesystem::path>& programs) {
  CatalogMemory memory;
  if (!memory_file_.empty() && disk_.Stat(memory_file_)) {
    memory.entries = json::parse(disk_.Read(memory_file_), nullptr, false);
    if (!memory.entries.is_object()) memory.entries = json::object();
  }
  std::vector<std::string> unknown;
  for (const auto& program : programs) {
    if (!stages_.contains(program.string()) && !Recall(program.string(), memory))
      unknown.push_back(program.string());
  }
  if (unknown.empty()) return;
  std::vector<std::vector<std::string>> questions;
  for (const std::string& program : unknown) questions.push_back({program, "--describe"});
  asked_ += SizeOf(unknown);
  std::vector<std::optional<FileStat>> before;
  for (const std::string& program : unknown) before.push_back(disk_.Stat(program));
  const auto answers = processes_.Ask(questions);
  if (processes_.interrupted()) throw Cancelled();
  for (std::size_t i = 0; i < unknown.size(); ++i) Learn(unknown[i], before[i], answers[i], memory);
  try {
    if (!memory_file_.empty()) disk_.Write(memory_file_, memory.entries.dump(0));
  } catch (const DiskError&) {
    // Not an error: if this cannot be saved (full or read-only disk), the programs are run again
    // next time.
  }
}

const StageInfo& StageCatalog::Get(const std::filesystem::path& program) const {
  return stages_.at(program.string());
}

}  // namespace keypose::pipeline
