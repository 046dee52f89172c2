// The context of a running stage: its ports' paths, its outputs, which appear only on success, and
// its report. Used by stage_main.cpp only.
#pragma once

#include <mutex>
#include <nlohmann/json.hpp>

#include "core/stage/output_guard.h"
#include "core/stage/stage.h"

namespace keypose::internal {

/// How outputs are put into place.
struct Placing {
  bool overwrite = false;  ///< folders that this stage did not write may be replaced
  bool mark = false;       ///< mark output folders (MarkFolder); not for the runner, which owns its
                           ///< folders and identifies them by content
};

/// Outputs are written to hidden temporary folders next to their final place, and are renamed by
/// Commit.
class RunningStage final : public StageContext {
 public:
  RunningStage(const StageSpec& spec, PortPaths inputs, PortPaths outputs, Placing placing,
               Progress* progress);
  ~RunningStage() override;  ///< removes outputs that were not committed, and the scratch folder

  bool Has(std::string_view port) const override;
  std::filesystem::path Input(std::string_view port) const override;
  std::vector<std::filesystem::path> Inputs(std::string_view port) const override;
  std::filesystem::path Output(std::string_view port) override;
  std::filesystem::path Scratch() override;
  Progress* progress() override { return progress_; }
  using StageContext::Report;
  void Report(std::string_view name, double value) override;
  void Report(std::string_view name, std::int64_t value) override {
    measurements_[std::string(name)] = value;
  }
  void Report(std::string_view name, bool value) override {
    measurements_[std::string(name)] = value;
  }
  void Report(std::string_view name, const std::string& value) override {
    measurements_[std::string(name)] = value;
  }
  void ReportJson(std::string_view name, const std::string& json) override;
  void Note(const std::string& line) override;
  void Warn(const std::string& sentence) override;
  void Verdict(const std::string& about, const std::string& grade, const std::string& why) override;

  /// Moves all outputs to their final paths.
  /// @throws InputError a promised output was not written
  /// @throws DiskError
  void Commit();
  /// Removes all outputs and the scratch folder, from any thread, while the stage is at work.
  /// @return false, with nothing done: the outputs are being moved, or have been
  bool Abandon();
  const nlohmann::json& measurements() const { return measurements_; }
  const nlohmann::json& warnings() const { return warnings_; }
  const nlohmann::json& verdicts() const { return verdicts_; }

 private:
  struct Pending {
    std::string port;
    std::filesystem::path temporary_folder, temporary, final_path;
    bool is_folder = false;
  };
  void Place(const Pending& pending) const;
  void RemoveTemporaries();

  const StageSpec& spec_;
  PortPaths inputs_, outputs_;
  Placing placing_;
  Progress* progress_;
  std::vector<Pending> pending_;
  std::filesystem::path scratch_;
  std::mutex mutex_;  ///< of `pending_`, `scratch_`, and the whole of Commit and Abandon
  bool committed_ = false;
  nlohmann::json measurements_ = nlohmann::json::object();
  nlohmann::json warnings_ = nlohmann::json::array(), verdicts_ = nlohmann::json::array();
};

}  // namespace keypose::internal
