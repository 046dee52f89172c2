#include "reconstruct/matching/colmap_database.h"

#include <sqlite3.h>

#include <cmath>
#include <cstring>
#include <iterator>

#include "core/values/errors.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMaxImages = 2147483647;
constexpr int kDescriptorSize = 128, kSimpleRadial = 2;

constexpr const char* kSchema = R"(
CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL, width INTEGER NOT NULL,
  height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL,
  prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL, prior_ty REAL, prior_tz REAL,
  CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647), FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB);
CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols INTEGER NOT NULL, data BLOB,
  config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
)";

[[noreturn]] void Throw(sqlite3* database, const std::string& what) {
  throw DiskError("the matching database: " + what + ": " +
                  (database ? sqlite3_errmsg(database) : "out of memory") +
                  "; check free space in the temporary folder");
}

/// A prepared statement with automatic release.
class Statement {
 public:
  Statement(sqlite3* database, const char* sql) : database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK)
      Throw(database, sql);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  void Bind(int at, std::int64_t value) { sqlite3_bind_int64(statement_, at, value); }
  void Bind(int at, const std::string& value) {
    sqlite3_bind_text(statement_, at, value.c_str(), -1, SQLITE_TRANSIENT);
  }
  void BindBlob(int at, const void* data, std::size_t bytes) {
    sqlite3_bind_blob(statement_, at, data, static_cast<int>(bytes), SQLITE_TRANSIENT);
  }
  /// @return whether there is a row
  bool Next() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) Throw(database_, "a statement failed");
    return code == SQLITE_ROW;
  }
  void RunOnce() {
    Next();
    sqlite3_reset(statement_);
  }
  std::int64_t Integer(int column) const { return sqlite3_column_int64(statement_, column); }
  const void* Blob(int column) const { return sqlite3_column_blob(statement_, column); }
  std::size_t Bytes(int column) const {
    return static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  }

 private:
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

sqlite3* OpenFile(const fs::path& path, int flags) {
  sqlite3* database = nullptr;
  if (sqlite3_open_v2(path.c_str(), &database, flags, nullptr) != SQLITE_OK) {
    const std::string reason = database ? sqlite3_errmsg(database) : "out of memory";
    sqlite3_close(database);
    throw DiskError("cannot open the matching database " + path.string() + ": " + reason);
  }
  return database;
}

/// @param values  x, y and an affine shape by rows, or x, y, scale and more
bool IsAtEnd(const PicturePlace& place, bool affine, const float* values) {
  const double scale = affine ? std::hypot(values[2], values[4]) : values[2];
  return std::min(place.width - values[0], place.height - values[1]) < place.scales_to_end * scale;
}

/// Leaves out features by the picture's right and lower side, where that is asked for.
void LeaveOutEnds(const PicturePlace& place, std::size_t columns, std::vector<float>& keypoints,
                  std::vector<std::uint8_t>& descriptors) {
  if (place.scales_to_end <= 0) return;
  std::size_t kept = 0;
  for (std::size_t f = 0; f * columns < keypoints.size(); ++f) {
    if (IsAtEnd(place, columns == 6, &keypoints[f * columns])) continue;
    std::copy_n(keypoints.begin() + static_cast<std::ptrdiff_t>(f * columns), columns,
                keypoints.begin() + static_cast<std::ptrdiff_t>(kept * columns));
    std::copy_n(descriptors.begin() + static_cast<std::ptrdiff_t>(f * kDescriptorSize),
                kDescriptorSize,
                descriptors.begin() + static_cast<std::ptrdiff_t>(kept * kDescriptorSize));
    ++kept;
  }
  keypoints.resize(kept * columns);
  descriptors.resize(kept * kDescriptorSize);
}

/// @param values  as above
void MoveFeature(const PicturePlace& place, bool affine, float* values) {
  values[0] = static_cast<float>((values[0] + place.x0) * place.pixels_x);
  values[1] = static_cast<float>((values[1] + place.y0) * place.pixels_y);
  if (place.pixels_x == 1 && place.pixels_y == 1) return;
  if (!affine) {
    values[2] = static_cast<float>(values[2] * std::sqrt(place.pixels_x * place.pixels_y));
    return;
  }
  for (int k = 2; k < 6; ++k)
    values[k] = static_cast<float>(values[k] * (k < 4 ? place.pixels_x : place.pixels_y));
}

std::int64_t PairId(int first, int second) { return kMaxImages * (first + 1) + second + 1; }

}  // namespace

void ColmapDatabase::Closer::operator()(sqlite3* database) const { sqlite3_close(database); }
ColmapDatabase::ColmapDatabase(const fs::path& path)
    : database_(OpenFile(path, SQLITE_OPEN_READWRITE)) {}
ColmapDatabase::~ColmapDatabase() = default;
ColmapDatabase::ColmapDatabase(ColmapDatabase&&) noexcept = default;

void ColmapDatabase::Execute(const std::string& sql) const {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    Throw(database_.get(), "a statement failed");
}

ColmapDatabase ColmapDatabase::Create(const fs::path& path, const std::vector<Camera>& cameras,
                                      bool focal_known, const std::vector<std::string>& images,
                                      const std::vector<int>& camera_of_image) {
  ColmapDatabase database(OpenFile(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE));
  database.Execute("PRAGMA synchronous = OFF");
  database.Execute(kSchema);
  database.Execute("BEGIN");
  Statement add_camera(database.database_.get(), "INSERT INTO cameras VALUES (?, ?, ?, ?, ?, ?)");
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Camera& camera = cameras[c];
    const double parameters[4] = {camera.fx, camera.cx, camera.cy, camera.k1};
    add_camera.Bind(1, static_cast<std::int64_t>(c + 1));
    add_camera.Bind(2, kSimpleRadial);
    add_camera.Bind(3, camera.width);
    add_camera.Bind(4, camera.height);
    add_camera.BindBlob(5, parameters, sizeof parameters);
    add_camera.Bind(6, focal_known ? 1 : 0);
    add_camera.RunOnce();
  }
  Statement add_image(database.database_.get(),
                      "INSERT INTO images (image_id, name, camera_id) VALUES (?, ?, ?)");
  for (std::size_t i = 0; i < images.size(); ++i) {
    add_image.Bind(1, static_cast<std::int64_t>(i + 1));
    add_image.Bind(2, images[i]);
    add_image.Bind(3, camera_of_image[i] + 1);
    add_image.RunOnce();
  }
  database.Execute("COMMIT");
  return database;
}

void ColmapDatabase::SetFocals(const std::vector<Camera>& cameras) const {
  Statement update(database_.get(), "UPDATE cameras SET params = ? WHERE camera_id = ?");
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const Camera& camera = cameras[c];
    const double parameters[4] = {camera.fx, camera.cx, camera.cy, camera.k1};
    update.BindBlob(1, parameters, sizeof parameters);
    update.Bind(2, static_cast<std::int64_t>(c + 1));
    update.RunOnce();
  }
}

int ColmapDatabase::LongestSide() const {
  Statement longest(database_.get(), "SELECT MAX(MAX(width, height)) FROM cameras");
  return longest.Next() ? static_cast<int>(longest.Integer(0)) : 0;
}

Features ColmapDatabase::ReadFeatures(int image) const {
  Features features;
  Statement keypoints(database_.get(), "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  keypoints.Bind(1, image + 1);
  if (!keypoints.Next()) return features;
  const auto rows = keypoints.Integer(0), columns = keypoints.Integer(1);
  Statement descriptors(database_.get(),
                        "SELECT rows, cols, data FROM descriptors WHERE image_id = ?");
  descriptors.Bind(1, image + 1);
  const bool fits =
      descriptors.Next() && descriptors.Integer(0) == rows &&
      descriptors.Integer(1) == kDescriptorSize &&
      descriptors.Bytes(2) == static_cast<std::size_t>(rows) * kDescriptorSize &&
      keypoints.Bytes(2) == static_cast<std::size_t>(rows * columns) * sizeof(float) &&
      (columns == 6 || columns == 4);
  if (!fits)
    throw ToolError("COLMAP wrote features of an unknown form for image " +
                    std::to_string(image + 1) + "; version 3.8 is expected");
  const auto* values = static_cast<const float*>(keypoints.Blob(2));
  features.positions.resize(rows, 2);
  features.scales.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const float* v = values + i * columns;
    features.positions.row(i) << v[0], v[1];
    features.scales(i) = columns == 6 ? std::sqrt(std::abs(v[2] * v[5] - v[3] * v[4])) : v[2];
  }
  const auto* bytes = static_cast<const std::uint8_t*>(descriptors.Blob(2));
  features.descriptors.assign(bytes, bytes + rows * kDescriptorSize);
  return features;
}

ColmapDatabase::Described ColmapDatabase::ReadDescribed(const PlacedPicture& picture) const {
  Statement keypoints(database_.get(),
                      "SELECT k.rows, k.cols, k.data FROM keypoints k JOIN images i USING "
                      "(image_id) WHERE i.name = ?");
  keypoints.Bind(1, picture.name);
  if (!keypoints.Next()) return {};
  const auto rows = keypoints.Integer(0), columns = keypoints.Integer(1);
  Statement descriptors(
      database_.get(),
      "SELECT d.data FROM descriptors d JOIN images i USING (image_id) WHERE i.name = ?");
  descriptors.Bind(1, picture.name);
  const auto values = static_cast<std::size_t>(rows * columns);
  if ((columns != 6 && columns != 4) || keypoints.Bytes(2) != values * sizeof(float) ||
      !descriptors.Next() ||
      descriptors.Bytes(0) != static_cast<std::size_t>(rows) * kDescriptorSize)
    throw ToolError("COLMAP wrote features of an unknown form for " + picture.name +
                    "; version 3.8 is expected");
  Described features{columns, std::vector<float>(values),
                     std::vector<std::uint8_t>(static_cast<std::size_t>(rows) * kDescriptorSize)};
  if (rows == 0) return features;
  std::memcpy(features.keypoints.data(), keypoints.Blob(2), values * sizeof(float));
  std::memcpy(features.descriptors.data(), descriptors.Blob(0), features.descriptors.size());
  const auto step = static_cast<std::size_t>(columns);
  LeaveOutEnds(picture.place, step, features.keypoints, features.descriptors);
  for (std::size_t i = 0; i < features.keypoints.size(); i += step)
    MoveFeature(picture.place, columns == 6, &features.keypoints[i]);
  return features;
}

void ColmapDatabase::AddFeaturesFrom(const ColmapDatabase& other,
                                     const std::vector<PlacedPicture>& pictures, int image) {
  Described all;
  for (const PlacedPicture& picture : pictures) {
    const Described one = other.ReadDescribed(picture);
    if (one.columns == 0) continue;
    all.columns = one.columns;
    all.keypoints.insert(all.keypoints.end(), one.keypoints.begin(), one.keypoints.end());
    all.descriptors.insert(all.descriptors.end(), one.descriptors.begin(), one.descriptors.end());
  }
  if (all.columns == 0) return;
  const auto kept = static_cast<std::int64_t>(all.descriptors.size() / kDescriptorSize);
  for (const bool is_keypoints : {true, false}) {
    Statement add(database_.get(), is_keypoints ? "INSERT INTO keypoints (image_id, rows, cols, data) VALUES (?, ?, ?, ?)"
                                                : "INSERT INTO descriptors (image_id, rows, cols, data) VALUES (?, ?, ?, ?)");
    add.Bind(1, image + 1);
    add.Bind(2, kept);
    add.Bind(3, is_keypoints ? all.columns : kDescriptorSize);
    if (is_keypoints)
      add.BindBlob(4, all.keypoints.data(), all.keypoints.size() * sizeof(float));
    else
      add.BindBlob(4, all.descriptors.data(), all.descriptors.size());
    add.RunOnce();
  }
}

std::vector<PairMatches> ColmapDatabase::VerifiedMatches() const {
  std::vector<PairMatches> pairs;
  Statement select(
      database_.get(),
      "SELECT pair_id, rows, data FROM two_view_geometries WHERE rows > 0 ORDER BY pair_id");
  while (select.Next()) {
    const std::int64_t id = select.Integer(0);
    PairMatches pair{
        static_cast<int>(id / kMaxImages) - 1, static_cast<int>(id % kMaxImages) - 1, {}};
    pair.features.resize(static_cast<std::size_t>(select.Integer(1)));
    if (select.Bytes(2) != 8 * pair.features.size())
      throw ToolError(
          "COLMAP wrote two-view geometries of an unknown form; version 3.8 is expected");
    std::memcpy(static_cast<void*>(pair.features.data()), select.Blob(2), 8 * pair.features.size());
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

void ColmapDatabase::PutInliers(const std::vector<PairMatches>& pairs) {
  constexpr int kUncalibrated = 3;
  Execute("BEGIN");
  Statement put(database_.get(),
                "INSERT OR REPLACE INTO two_view_geometries (pair_id, rows, cols, data, config) "
                "VALUES (?, ?, 2, ?, ?)");
  for (const PairMatches& pair : pairs) {
    put.Bind(1, PairId(pair.first, pair.second));
    put.Bind(2, std::ssize(pair.features));
    put.BindBlob(3, pair.features.data(), pair.features.size() * 8);
    put.Bind(4, kUncalibrated);
    put.RunOnce();
  }
  Execute("COMMIT");
}

}  // namespace keypose::reconstruct
