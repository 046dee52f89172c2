// Numbered pictures of a live puppet, drawn beside the stream so that they never hold it up.
#pragma once

#include <condition_variable>
#include <exception>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "armature/live/plate_view.h"
#include "armature/live/puppet_files.h"

namespace keypose::armature {

/// A thread that draws the newest pose that it is offered, and skips those that come while it
/// draws.
class PictureWriter {
 public:
  /// @param folder  is made; picture_00000.png and on
  /// All references must outlive this.
  /// @throws DiskError  the folder cannot be made
  PictureWriter(const PuppetLook& look, const PlateFiles& plates,
                const std::filesystem::path& folder);
  ~PictureWriter();
  PictureWriter(const PictureWriter&) = delete;
  PictureWriter& operator=(const PictureWriter&) = delete;

  /// @param ghosts  earlier poses, oldest first
  /// @return the name of the picture that will show it; "" if it is still drawing another
  /// @throws what drawing the last picture threw
  std::string Offer(const PointsX3& points, int plate, const std::vector<PointsX3>& ghosts);
  /// Waits for the picture that is being drawn.
  /// @throws what drawing it threw
  void Finish();
  int written() const { return written_; }

 private:
  struct Order {
    PointsX3 points;
    int plate = 0;
    std::vector<PointsX3> ghosts;
    std::filesystem::path path;
  };
  void Run();
  void Draw(const Order& order);
  void Rethrow();

  const PuppetLook& look_;
  const PlateFiles& plates_;
  std::filesystem::path folder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Order> order_;
  std::exception_ptr fault_;
  bool ends_ = false;
  int written_ = 0;
  int plate_at_ = -1;
  PlateView plate_;
  std::thread thread_;
};

}  // namespace keypose::armature
