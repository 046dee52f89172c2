// COLMAP 3.8's SQLite database: cameras, images, features, matches, two-view geometries.
//
// We write cameras and images ourselves, so that ids follow the names' order, and the verified
// matches of our own matcher; COLMAP's programs add features. Image ids count from 1.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/values/camera.h"
#include "core/values/size_of.h"

struct sqlite3;

namespace keypose::reconstruct {

/// Features of one image.
struct Features {
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor> positions;  ///< F x 2 [px]
  Eigen::VectorXf scales;                                              ///< F [px]
  std::vector<std::int16_t> descriptors;                               ///< F x 128, each 0..255
  int count() const { return SizeOf(scales); }
};

/// Matched features of two images, first < second (0-based images).
struct PairMatches {
  int first = 0, second = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> features;
};

/// The geometric relation of two images.
struct PairGeometry {
  enum Kind { kFundamental, kHomography, kOther } kind = kOther;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  ///< fundamental matrix (second^T F first = 0)
                                                     ///< or homography second <- first, in pixels
};

/// Where the picture that features were found in lies in its photograph.
struct PicturePlace {
  double x0 = 0, y0 = 0;  ///< its corner [its px]
  /// the photograph's pixels for each of its own
  double pixels_x = 1, pixels_y = 1;
  int width = 0, height = 0;  ///< of the picture [its px]; needed for the next
  /// features that are fewer of their scales from the right or lower side are left out: COLMAP 3.8
  /// leaves descriptors there unset unless it adapts features to slanted surfaces
  double scales_to_end = 0;
};

/// A picture of a photograph, or of a part of it, that features were found in.
struct PlacedPicture {
  std::string name;  ///< in the database of its features
  PicturePlace place;
};

class ColmapDatabase {
 public:
  /// A new database with SIMPLE_RADIAL cameras and the images in the order given.
  /// @param camera_of_image  for each image the index of its camera
  /// @throws DiskError  cannot be written
  static ColmapDatabase Create(const std::filesystem::path& path,
                               const std::vector<Camera>& cameras, bool focal_known,
                               const std::vector<std::string>& images,
                               const std::vector<int>& camera_of_image);
  /// @throws DiskError  cannot be opened
  explicit ColmapDatabase(const std::filesystem::path& path);
  ~ColmapDatabase();
  ColmapDatabase(ColmapDatabase&&) noexcept;
  ColmapDatabase(const ColmapDatabase&) = delete;

  /// Sets other initial focal lengths of the cameras, in the order in which they were created.
  void SetFocals(const std::vector<Camera>& cameras) const;
  /// The longest side of the cameras' pictures [px].
  int LongestSide() const;
  /// Features of image i (0-based); none when COLMAP found none.
  Features ReadFeatures(int image) const;
  /// Copies the features that another database has of pictures of one photograph to image i
  /// (0-based), moved to their places in the photograph.
  void AddFeaturesFrom(const ColmapDatabase& other, const std::vector<PlacedPicture>& pictures,
                       int image);
  /// The matched features of pairs that passed the geometric test, by pair id.
  std::vector<PairMatches> VerifiedMatches() const;
  /// Adds pairs with their inliers, or replaces those of existing pairs.
  void PutInliers(const std::vector<PairMatches>& pairs);

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  explicit ColmapDatabase(sqlite3* database) : database_(database) {}
  void Execute(const std::string& sql) const;
  /// Keypoints of so many values each, in the photograph, and their descriptors.
  struct Described {
    std::int64_t columns = 0;  ///< 0: the picture has none
    std::vector<float> keypoints;
    std::vector<std::uint8_t> descriptors;
  };
  Described ReadDescribed(const PlacedPicture& picture) const;
  std::unique_ptr<sqlite3, Closer> database_;
};

}  // namespace keypose::reconstruct
