// For tests of what runs inside of a stage: a stage without ports.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/stage/stage.h"

namespace keypose::reconstruct {

/// A stage of which only the report is used.
class ReportedStage final : public StageContext {
 public:
  bool Has(std::string_view) const override { return false; }
  std::filesystem::path Input(std::string_view) const override { return {}; }
  std::vector<std::filesystem::path> Inputs(std::string_view) const override { return {}; }
  std::filesystem::path Output(std::string_view) override { return {}; }
  std::filesystem::path Scratch() override { return {}; }
  Progress* progress() override { return nullptr; }
  using StageContext::Report;
  void Report(std::string_view name, double value) override { Put(name, std::to_string(value)); }
  void Report(std::string_view name, std::int64_t value) override {
    Put(name, std::to_string(value));
  }
  void Report(std::string_view name, bool value) override { Put(name, value ? "true" : "false"); }
  void Report(std::string_view name, const std::string& value) override { Put(name, value); }
  void ReportJson(std::string_view name, const std::string& json) override { Put(name, json); }
  void Note(const std::string&) override {}
  void Warn(const std::string& sentence) override { warnings.push_back(sentence); }
  void Verdict(const std::string&, const std::string&, const std::string&) override {}

  std::map<std::string, std::string> values;
  std::vector<std::string> warnings;

 private:
  void Put(std::string_view name, std::string value) {
    values[std::string(name)] = std::move(value);
  }
};

}  // namespace keypose::reconstruct
