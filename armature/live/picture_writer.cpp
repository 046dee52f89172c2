#include "armature/live/picture_writer.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/values/errors.h"

namespace keypose::armature {

namespace fs = std::filesystem;

PictureWriter::PictureWriter(const PuppetLook& look, const PlateFiles& plates,
                             const fs::path& folder)
    : look_(look), plates_(plates), folder_(folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError("armature: cannot make the folder " + folder.string() + ": " + error.message());
  thread_ = std::thread([this] { Run(); });
}

PictureWriter::~PictureWriter() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::string PictureWriter::Offer(const PointsX3& points, int plate,
                                 const std::vector<PointsX3>& ghosts) {
  const std::lock_guard lock(mutex_);
  Rethrow();
  if (order_) return "";
  const std::string name = fmt::format("picture_{:05}.png", written_++);
  order_ = Order{points, plate, ghosts, folder_ / name};
  changed_.notify_all();
  return name;
}

void PictureWriter::Finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !order_; });
  Rethrow();
}

void PictureWriter::Rethrow() {
  if (fault_) std::rethrow_exception(std::exchange(fault_, nullptr));
}

void PictureWriter::Run() {
  // On Linux this is the priority of this thread only: the stream goes first.
  setpriority(PRIO_PROCESS, 0, 10);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return order_ || ends_; });
    if (!order_) return;
    const Order& order = *order_;
    lock.unlock();
    std::exception_ptr fault;
    try {
      Draw(order);
    } catch (...) {
      fault = std::current_exception();
    }
    lock.lock();
    if (fault) fault_ = fault;
    order_.reset();
    changed_.notify_all();
  }
}

void PictureWriter::Draw(const Order& order) {
  if (order.plate != plate_at_) plate_ = plates_.Read(order.plate);
  plate_at_ = order.plate;
  std::vector<const PointsX3*> ghosts;
  for (const PointsX3& ghost : order.ghosts) ghosts.push_back(&ghost);
  // Whoever watches the folder sees whole pictures only.
  fs::path temporary = order.path;
  temporary.replace_filename("." + order.path.filename().string());
  WriteImage(temporary, DrawPuppet(look_, plate_, order.points, ghosts));
  std::error_code error;
  fs::rename(temporary, order.path, error);
  if (error)
    throw DiskError("armature: cannot write " + order.path.string() + ": " + error.message());
}

}  // namespace keypose::armature
