// What really stands on the simulated set: the table's true angle, the camera's height, the figure.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>

namespace keypose::capture::shoot {

/// Thread-safe. Kept in a file, as a real table keeps its angle when the program is killed.
class SimulatedWorld {
 public:
  /// @param file  read if it is there; empty: kept in memory only
  explicit SimulatedWorld(const std::filesystem::path& file);

  double table_deg() const;  ///< any number of turns
  void SetTable(double angle_deg);
  int ring() const;
  int flip() const;
  std::string pose() const;
  void SetCamera(int ring);
  void SetFigure(const std::string& pose, int flip);

 private:
  void Save() const;
  mutable std::mutex mutex_;
  std::filesystem::path file_;
  double table_deg_ = 0;
  int ring_ = 1, flip_ = 0;
  std::string pose_;
};

}  // namespace keypose::capture::shoot
