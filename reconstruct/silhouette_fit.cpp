#include "reconstruct/silhouette_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/facing_cells.h"
#include "reconstruct/weighted_median.h"

namespace keypose::reconstruct {
namespace {

constexpr int kBin = 2;               // pixels of the outline that share a gap
constexpr int kNeighbors = 32;        // gaps that a point listens to
constexpr double kLeastFacing = 0.7;  // cosine between a point's normal and the outline's plane
constexpr int kGrain = 512;

// Where the cloud's outline meets a mask's.
struct Contact {
  Eigen::Vector3d point, normal;
  double gap_px = 0, footprint = 0;
};

// The three outermost points of a bin: the third is its outline, so that two strays cannot make one.
struct Outermost {
  float distance[3] = {-1e9f, -1e9f, -1e9f};
  int point[3] = {-1, -1, -1};
  void Add(float d, int index) {
    for (int k = 0; k < 3; ++k)
      if (d > distance[k]) std::swap(d, distance[k]), std::swap(index, point[k]);
  }
};

std::vector<Contact> ContactsOf(const PointCloud& cloud, const Silhouettes& silhouettes, int view, double reach) {
  const MaskField& field = silhouettes.field(view);
  const int width = field.width / kBin + 1, height = field.height / kBin + 1;
  std::vector<Outermost> bins(static_cast<std::size_t>(width) * height);
  for (int i = 0; i < cloud.points.rows(); ++i) {
    const Eigen::Vector3d x = cloud.points.row(i);
    const Eigen::Vector3d h = field.from_world * x.homogeneous();
    if (h.z() <= 0) continue;
    const double px = h.x() / h.z(), py = h.y() / h.z();
    if (!(px >= 1 && py >= 1 && px < field.width - 2 && py < field.height - 2)) continue;
    const int ix = static_cast<int>(px + 0.5), iy = static_cast<int>(py + 0.5);
    if (std::abs(field.At(ix, iy)) > reach) continue;
    // The foot on the outline, by the distance's slope.
    Eigen::Vector2d slope(field.At(ix + 1, iy) - field.At(ix - 1, iy), field.At(ix, iy + 1) - field.At(ix, iy - 1));
    if (slope.norm() < 0.5) continue;
    slope.normalize();
    const double d = silhouettes.See(view, x).distance;
    const double fx = px - d * slope.x(), fy = py - d * slope.y();
    if (!(fx >= 0 && fy >= 0 && fx <= field.width - 1 && fy <= field.height - 1)) continue;
    bins[static_cast<std::size_t>(fy / kBin) * width + static_cast<std::size_t>(fx / kBin)].Add(static_cast<float>(d), i);
  }
  std::vector<Contact> contacts;
  for (const Outermost& bin : bins) {
    if (bin.point[2] < 0) continue;
    Contact contact;
    contact.point = cloud.points.row(bin.point[2]);
    contact.normal = silhouettes.RimNormal(view, contact.point);
    if (contact.normal.dot(cloud.normals.row(bin.point[2])) < kLeastFacing) continue;
    contact.gap_px = -bin.distance[2];
    contact.footprint = silhouettes.See(view, contact.point).footprint;
    contacts.push_back(contact);
  }
  return contacts;
}

std::vector<Contact> AllContacts(const PointCloud& cloud, const Silhouettes& silhouettes, double reach) {
  std::vector<std::vector<Contact>> of_view(silhouettes.views());
  ParallelFor(silhouettes.views(), [&](std::int64_t i) { of_view[i] = ContactsOf(cloud, silhouettes, static_cast<int>(i), reach); });
  std::vector<Contact> all;
  for (const std::vector<Contact>& contacts : of_view) all.insert(all.end(), contacts.begin(), contacts.end());
  return all;
}

class Field {
 public:
  Field(const std::vector<Contact>& contacts, double smoothing_px)
      : contacts_(contacts), smoothing_px_(smoothing_px), tree_(Points(contacts)) {}

  // The world length by which a point should move outwards.
  double Shift(const Eigen::Vector3d& x, const Eigen::Vector3d& normal) const {
    std::vector<std::pair<double, double>> gaps;
    double weights = 0;
    for (const KdTree::Neighbor& near : tree_.Nearest(x, kNeighbors)) {
      const Contact& contact = contacts_[near.index];
      const double facing = contact.normal.dot(normal);
      const double distance = std::sqrt(near.squared_distance) / (smoothing_px_ * contact.footprint);
      if (facing < kLeastFacing || distance > 3) continue;
      const double weight = facing * facing * facing * facing * std::exp(-0.5 * distance * distance);
      gaps.emplace_back(contact.gap_px * contact.footprint, weight);
      weights += weight;
    }
    if (weights < 1e-9) return 0;
    // Few and far gaps are believed less.
    return WeightedMedian(&gaps) * weights / (weights + 0.2);
  }

 private:
  static PointsX3 Points(const std::vector<Contact>& contacts) {
    PointsX3 points(contacts.size(), 3);
    for (std::size_t i = 0; i < contacts.size(); ++i) points.row(static_cast<int>(i)) = contacts[i].point;
    return points;
  }
  const std::vector<Contact>& contacts_;
  double smoothing_px_;
  KdTree tree_;
};

// Points of one small cell that face into the same octant move together: neighbours hear the same gaps, and asking once is far cheaper.
struct Sites {
  std::vector<int> site_of;  // for each point
  PointsX3 points, normals;  // means
};

Sites GroupPoints(const PointCloud& cloud, double cell) {
  const std::vector<KeyedPoint> keyed = SortByFacingCell(cloud, cell);
  Sites sites;
  sites.site_of.resize(keyed.size());
  int count = 0;
  for (std::size_t k = 0; k < keyed.size(); ++k) {
    if (k == 0 || keyed[k].key != keyed[k - 1].key) ++count;
    sites.site_of[keyed[k].point] = count - 1;
  }
  sites.points = PointsX3::Zero(count, 3), sites.normals = PointsX3::Zero(count, 3);
  Eigen::VectorXd members = Eigen::VectorXd::Zero(count);
  for (const KeyedPoint& k : keyed) {
    const int s = sites.site_of[k.point];
    sites.points.row(s) += cloud.points.row(k.point), sites.normals.row(s) += cloud.normals.row(k.point);
    ++members[s];
  }
  sites.points.array().colwise() /= members.array();
  sites.normals.rowwise().normalize();
  return sites;
}

void MovePoints(const Field& field, const Silhouettes& silhouettes, double cell, PointCloud* cloud) {
  const Sites sites = GroupPoints(*cloud, cell);
  Eigen::VectorXd shifts(sites.points.rows());
  ParallelBlocks(sites.points.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t s = begin; s < end; ++s) {
      const Eigen::Vector3d x = sites.points.row(s), normal = sites.normals.row(s);
      double shift = field.Shift(x, normal);
      for (int k = 0; k < 4 && shift > 0 && !silhouettes.Within(x + shift * normal, 0.5); ++k) shift = k < 3 ? 0.5 * shift : 0;
      shifts[s] = shift;
    }
  });
  for (Eigen::Index i = 0; i < cloud->points.rows(); ++i) cloud->points.row(i) += shifts[sites.site_of[i]] * cloud->normals.row(i);
}

double MeanGap(const std::vector<Contact>& contacts, bool absolute) {
  double sum = 0;
  for (const Contact& contact : contacts) sum += absolute ? std::abs(contact.gap_px) : contact.gap_px;
  return contacts.empty() ? 0 : sum / static_cast<double>(contacts.size());
}

double MedianFootprint(const std::vector<Contact>& contacts) {
  std::vector<double> values;
  for (const Contact& contact : contacts) values.push_back(contact.footprint);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

}  // namespace

SilhouetteFit FitToSilhouettes(const PointCloud& cloud, const Silhouettes& silhouettes, const SilhouetteFitOptions& options) {
  SilhouetteFit out;
  out.cloud = cloud;
  for (int round = 0; round <= options.rounds; ++round) {
    const std::vector<Contact> contacts = AllContacts(out.cloud, silhouettes, options.reach_px);
    (round == 0 ? out.gap_before_px : out.gap_after_px) = MeanGap(contacts, false);
    out.gap_spread_px = MeanGap(contacts, true);
    if (round == options.rounds || contacts.empty()) break;
    const Field field(contacts, options.smoothing_px);
    MovePoints(field, silhouettes, options.smoothing_px / 3 * MedianFootprint(contacts), &out.cloud);
  }
  return out;
}

}  // namespace keypose::reconstruct
