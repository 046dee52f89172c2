#include "register/intrinsic/skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/values/union_find.h"

namespace keypose::registration {

namespace {

constexpr int kMargin = 2;           // cells around the body
constexpr int kSmoothings = 8;       // steps of a cut lie within a cell
constexpr double kHalfStep = 0.5;    // of a smoothing
constexpr double kAside_x = 0.0137;  // of a cell: rays meet no edge of a regular mesh
constexpr double kAside_y = 0.0291;

/// For each face the number of its piece: faces that share a vertex.
std::vector<int> PiecesOf(const Mesh& mesh) {
  UnionFind vertices(mesh.vertex_count());
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 1; k < 3; ++k) vertices.Join(mesh.faces(f, 0), mesh.faces(f, k));
  std::vector<int> piece(static_cast<std::size_t>(mesh.face_count()));
  for (int f = 0; f < mesh.face_count(); ++f) piece[f] = vertices.Find(mesh.faces(f, 0));
  return piece;
}

bool IsWhole(const Mesh& mesh, const std::vector<int>& piece, double share) {
  const Eigen::VectorXd areas = FaceAreas(mesh.points, mesh.faces);
  Eigen::VectorXd of_piece = Eigen::VectorXd::Zero(mesh.vertex_count());
  for (int f = 0; f < mesh.face_count(); ++f) of_piece[piece[f]] += areas[f];
  return of_piece.maxCoeff() > share * areas.sum();
}

/// Nodes of a grid, and which of them lie inside of a piece.
class Grid {
 public:
  Grid(const Mesh& mesh, const std::vector<int>& piece, int cells) {
    const Eigen::Vector3d low = mesh.points.colwise().minCoeff(),
                          high = mesh.points.colwise().maxCoeff();
    cell_ = (high - low).maxCoeff() / cells;
    origin_ = low - Eigen::Vector3d::Constant(kMargin * cell_);
    for (int k = 0; k < 3; ++k)
      size_[k] = static_cast<int>(std::ceil((high[k] - low[k]) / cell_)) + 2 * kMargin + 1;
    inside_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], 0);
    Fill(mesh, piece);
  }
  const Eigen::Vector3i& size() const { return size_; }
  double cell() const { return cell_; }
  std::int64_t Index(const Eigen::Vector3i& node) const {
    return (static_cast<std::int64_t>(node[2]) * size_[1] + node[1]) * size_[0] + node[0];
  }
  bool Inside(const Eigen::Vector3i& node) const {
    return inside_[static_cast<std::size_t>(Index(node))] != 0;
  }
  Eigen::Vector3d Place(const Eigen::Vector3i& node) const {
    return origin_ + cell_ * node.cast<double>();
  }

 private:
  struct Crossing {
    int piece;
    double z;
  };

  /// Upright rays through all columns of nodes; between two crossings of a piece lies its inside.
  void Fill(const Mesh& mesh, const std::vector<int>& piece) {
    std::vector<std::vector<Crossing>> columns(static_cast<std::size_t>(size_[0]) * size_[1]);
    for (int f = 0; f < mesh.face_count(); ++f) AddFace(mesh, f, piece[f], columns);
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x)
        FillColumn(x, y, columns[static_cast<std::size_t>(y) * size_[0] + x]);
  }

  void AddFace(const Mesh& mesh, int face, int piece, std::vector<std::vector<Crossing>>& columns) {
    Eigen::Matrix3d corner;  // in cells
    for (int k = 0; k < 3; ++k)
      corner.col(k) = (mesh.points.row(mesh.faces(face, k)).transpose() - origin_) / cell_ -
                      Eigen::Vector3d(kAside_x, kAside_y, 0);
    const Eigen::Vector2d a = corner.col(0).head<2>(), u = corner.col(1).head<2>() - a,
                          v = corner.col(2).head<2>() - a;
    const double area = u.x() * v.y() - u.y() * v.x();
    if (area == 0) return;
    const Eigen::Vector2i from =
                              corner.topRows<2>().rowwise().minCoeff().array().ceil().cast<int>(),
                          to = corner.topRows<2>().rowwise().maxCoeff().array().floor().cast<int>();
    for (int y = from.y(); y <= to.y(); ++y)
      for (int x = from.x(); x <= to.x(); ++x) {
        const Eigen::Vector2d p = Eigen::Vector2d(x, y) - a;
        const double s = (p.x() * v.y() - p.y() * v.x()) / area,
                     t = (u.x() * p.y() - u.y() * p.x()) / area;
        if (s < 0 || t < 0 || s + t > 1) continue;
        const double z =
            corner(2, 0) + s * (corner(2, 1) - corner(2, 0)) + t * (corner(2, 2) - corner(2, 0));
        columns[static_cast<std::size_t>(y) * size_[0] + x].push_back({piece, z});
      }
  }

  void FillColumn(int x, int y, std::vector<Crossing>& crossings) {
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
      return std::pair(a.piece, a.z) < std::pair(b.piece, b.z);
    });
    for (std::size_t i = 0; i + 1 < crossings.size();) {
      if (crossings[i].piece != crossings[i + 1].piece) {  // a hole in it
        ++i;
        continue;
      }
      for (int z = static_cast<int>(std::ceil(crossings[i].z)); z <= crossings[i + 1].z; ++z)
        inside_[static_cast<std::size_t>(Index({x, y, z}))] = 1;
      i += 2;
    }
  }

  Eigen::Vector3d origin_;
  double cell_ = 1;
  Eigen::Vector3i size_;
  std::vector<char> inside_;
};

/// Cuts the tetrahedra of all cells, six in each, between inside and outside.
class Cutter {
 public:
  explicit Cutter(const Grid& grid) : grid_(grid) {}

  Mesh Cut() {
    const Eigen::Vector3i last = grid_.size().array() - 1;
    for (int z = 0; z < last[2]; ++z)
      for (int y = 0; y < last[1]; ++y)
        for (int x = 0; x < last[0]; ++x) CutCell({x, y, z});
    Mesh mesh;
    mesh.points.resize(std::ssize(places_), 3);
    for (std::size_t i = 0; i < places_.size(); ++i)
      mesh.points.row(static_cast<Eigen::Index>(i)) = places_[i];
    mesh.faces.resize(std::ssize(faces_), 3);
    for (std::size_t i = 0; i < faces_.size(); ++i)
      mesh.faces.row(static_cast<Eigen::Index>(i)) = faces_[i];
    return mesh;
  }

 private:
  using Tetrahedron = std::array<Eigen::Vector3i, 4>;

  void CutCell(const Eigen::Vector3i& cell) {
    static constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                          {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    int count = 0;
    for (int corner = 0; corner < 8; ++corner)
      count +=
          grid_.Inside(cell + Eigen::Vector3i(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1));
    if (count == 0 || count == 8) return;
    for (const auto& order : kOrders) {
      Tetrahedron nodes = {cell, cell, cell, cell};
      for (int k = 0; k < 3; ++k)
        for (int i = k + 1; i < 4; ++i) nodes[i][order[k]] += 1;
      CutTetrahedron(nodes);
    }
  }

  void CutTetrahedron(const Tetrahedron& nodes) {
    std::vector<Eigen::Vector3i> in, out;
    for (const Eigen::Vector3i& node : nodes) (grid_.Inside(node) ? in : out).push_back(node);
    if (in.empty() || out.empty()) return;
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3i& node : out)
      outward += node.cast<double>() / static_cast<double>(out.size());
    for (const Eigen::Vector3i& node : in)
      outward -= node.cast<double>() / static_cast<double>(in.size());
    if (in.size() == 2) {
      const int a = Between(in[0], out[0]), b = Between(in[0], out[1]), c = Between(in[1], out[1]),
                d = Between(in[1], out[0]);
      AddFace(a, b, c, outward);
      AddFace(a, c, d, outward);
    } else if (in.size() == 1) {
      AddFace(Between(in[0], out[0]), Between(in[0], out[1]), Between(in[0], out[2]), outward);
    } else {
      AddFace(Between(in[0], out[0]), Between(in[1], out[0]), Between(in[2], out[0]), outward);
    }
  }

  /// The vertex in the middle of an edge of the grid.
  int Between(const Eigen::Vector3i& in, const Eigen::Vector3i& out) {
    const std::int64_t a = grid_.Index(in), b = grid_.Index(out);
    const auto key = static_cast<std::uint64_t>(std::min(a, b)) << 32 |
                     static_cast<std::uint64_t>(std::max(a, b));
    const auto [at, is_new] = vertices_.try_emplace(key, static_cast<int>(places_.size()));
    if (is_new) places_.emplace_back((grid_.Place(in) + grid_.Place(out)) / 2);
    return at->second;
  }

  void AddFace(int a, int b, int c, const Eigen::Vector3d& outward) {
    const Eigen::Vector3d normal = (places_[b] - places_[a]).cross(places_[c] - places_[a]);
    if (normal.dot(outward) < 0) std::swap(b, c);
    faces_.emplace_back(a, b, c);
  }

  const Grid& grid_;
  std::unordered_map<std::uint64_t, int> vertices_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<Eigen::Vector3i> faces_;
};

void Smooth(Mesh& mesh) {
  for (int round = 0; round < kSmoothings; ++round) {
    PointsX3 sum = PointsX3::Zero(mesh.points.rows(), 3);
    Eigen::VectorXd count = Eigen::VectorXd::Zero(mesh.points.rows());
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        sum.row(mesh.faces(f, k)) += mesh.points.row(mesh.faces(f, (k + 1) % 3));
        count[mesh.faces(f, k)] += 1;
      }
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
      mesh.points.row(v) += kHalfStep * (sum.row(v) / count[v] - mesh.points.row(v));
  }
}

}  // namespace

std::optional<Mesh> SkinOfPieces(const Mesh& mesh, const SkinOptions& options) {
  const std::vector<int> piece = PiecesOf(mesh);
  if (IsWhole(mesh, piece, options.whole_share)) return std::nullopt;
  const Grid grid(mesh, piece, options.cells);
  Mesh skin = Cutter(grid).Cut();
  if (skin.face_count() == 0) return std::nullopt;  // no piece is closed
  Smooth(skin);
  return skin;
}

}  // namespace keypose::registration
