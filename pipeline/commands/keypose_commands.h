// The commands of `keypose`. Each prints to standard output and returns an exit code, or throws an
// error of core/values/errors.h.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/values/errors.h"
#include "pipeline/run/plan.h"

namespace keypose::pipeline {

struct RunOptions {
  std::string folder;  ///< -C
  Selection selection;
  std::vector<std::string> set;
  bool dry_run = false;
  int cores = 0;         ///< 0: all
  std::string progress;  ///< "", "bars", "lines", "jsonl"
  std::string command_line;
};
ExitCode RunCommand(const RunOptions& options);

struct InitOptions {
  std::string folder;
  std::vector<std::string> poses;  ///< NAME=PHOTO_DIR, or NAME=MESH
  std::string template_pose;
  std::vector<std::string> few, scan;  ///< names of poses: how they are found
  std::string kind = "poses";          ///< poses | performance
  std::vector<std::string> shots;      ///< NAME=FOLDER with films; of a performance
  /// of poses: what they were filmed in, FRAME=POSE, and files that belong to it; empty: none
  std::string film, plate, mattes, holdout;
  std::vector<std::string> shows;
  double film_fps = 0;  ///< 0: those of a video, else 12
  /// files of a performance, `texture` also of poses from meshes; empty: none
  std::string calibration, scan_mesh, texture, marks;
  bool same_faces = false;  ///< of meshes: they have the same faces, so none is registered
  bool video3d = false;     ///< of a performance: textures from the films
  bool surface = false;     ///< of a performance: the surface from the films
};
/// @throws UsageError  an option that only performances have
void RequireNoPerformance(const InitOptions& options);
ExitCode InitCommand(const InitOptions& options);
/// Whether a pose is given as a mesh instead of as a folder of photographs.
bool NamesMesh(const InitOptions& options);
/// The project of poses whose meshes were made elsewhere. They are copied.
ExitCode InitMeshes(const InitOptions& options);
/// The project of a performance. Films stay where they are; the other files are copied.
ExitCode InitPerformance(const InitOptions& options);

/// @param details  verdicts in full
ExitCode StatusCommand(const std::string& folder, const std::vector<std::string>& set,
                       bool details);
ExitCode ExplainCommand(const std::string& folder, const std::string& step,
                        const std::vector<std::string>& set);
ExitCode LogCommand(const std::string& folder, const std::string& step);
ExitCode GraphCommand(const std::string& folder, bool dot);
ExitCode GcCommand(const std::string& folder, bool dry_run, int keep_runs);
/// Reads and hashes everything in the cache and in out/. Removes damaged artifacts from the cache;
/// the next run makes them again.
/// @return kDisk if something was damaged
ExitCode VerifyCommand(const std::string& folder);
/// Writes the whole project into one ZIP file that appears when it is complete.
/// @param output      empty: the project's name and .zip, in the working folder
/// @param with_cache  with results that are up to date, so that nothing runs again where it is
/// unpacked
/// @throws LockedError  a run is at work @throws DiskError  the file exists, or the disk is full
ExitCode PackCommand(const std::string& folder, const std::string& output, bool with_cache);
ExitCode UnlockCommand(const std::string& folder, bool force);
ExitCode ReportCommand(const std::string& folder);
ExitCode DoctorCommand();
ExitCode VersionCommand();

/// The text that `explain` prints for one step.
std::string Explanation(const Plan& plan, int step);
/// The same for all steps of STEP or STEP/POSE, with the steps above them where a change begins.
/// @throws UsageError  no step matches
std::string ExplanationWithCauses(const Plan& plan, const std::string& step);

class OpenedProject;
/// The log of a step's last end: of its failure, if it failed. Empty if there is none.
std::filesystem::path StepLog(OpenedProject& opened, const std::string& step_id);

}  // namespace keypose::pipeline
