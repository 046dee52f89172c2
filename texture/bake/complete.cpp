#include "texture/bake/complete.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"
#include "core/pictures/srgb16.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "texture/bake/bake_view.h"
#include "views/atlas/atlas.h"

namespace keypose::texture {
namespace {

using Eigen::Vector3f;

/// Chosen on the painted spheres of complete_test and the demo character (docs/results/texture.md).
struct CompletionTuning {
  /// least confidence (share of full) of both at a vertex for a comparison of their colours
  KEYPOSE_TUNED(float, kBothSure, 0.9f);
  /// linear light, added before logarithms: black consists of noise only
  KEYPOSE_TUNED(float, kDarkColor, 0.01f);
  /// weight of a vertex's own factor, in smoothness along one edge; low, so that a factor depends
  /// on many faces
  KEYPOSE_TUNED(double, kHold, 0.1);
  /// larger differences of logarithms of linear light are not caused by light
  KEYPOSE_TUNED(double, kSameThing, 0.12);
  /// rings of vertices over which confidence is averaged before the best pose is chosen
  KEYPOSE_TUNED(int, kRings, 3);
};
/// Weight of the overall factor, for regions without observations nearby.
constexpr double kSmoothingGrain = 1e-4;
constexpr int kRobustRounds = 4;

/// Width, height and channels of a pose's texture, of 8 or 16 bits.
struct TextureShape {
  int width, height, channels;
};
TextureShape ShapeOf(const PoseTexture& pose) {
  const auto of = [](const auto& image) {
    return TextureShape{image.width, image.height, image.channels};
  };
  return pose.deep.empty() ? of(pose.texture) : of(pose.deep);
}

template <class T>
void ToLinear(const ImageT<T>& srgb, const float* light, ImageF* linear) {
  ParallelBlocks(std::ssize(srgb.data), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) linear->data[i] = light[srgb.data[i]];
  });
}

Painting PaintingOf(const PoseTexture& pose) {
  Painting painting(ShapeOf(pose).width);
  painting.sure = pose.confidence.data;
  if (pose.deep.empty())
    ToLinear(pose.texture, kLinear.data(), &painting.color);
  else
    ToLinear(pose.deep, LinearTable16(), &painting.color);
  return painting;
}

void RequireSquare(const PoseTexture& pose, int size, const std::string& what) {
  const TextureShape shape = ShapeOf(pose);
  if (shape.width != size || shape.height != size || shape.channels != 3)
    throw InputError("complete: " + what + " is " + std::to_string(shape.width) + " x " +
                     std::to_string(shape.height) + ", but the pose's own is " +
                     std::to_string(size) +
                     " px wide; textures must be square and of one size: bake all "
                     "poses with one `texture_size`");
  if (pose.confidence.width != size || pose.confidence.height != size ||
      pose.confidence.channels != 1)
    throw InputError("complete: the confidence of " + what +
                     " is not of its texture's size; pass the one that the same bake wrote");
}

/// The edges of the mesh along which values are smooth.
using Edges = std::vector<std::pair<int, int>>;

/// Logarithms of the factors that adapt `other` to the light of `own`, one row per vertex. Empty if
/// too little is seen in both.
using Factors = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Logarithm of own over other, where both are confident.
struct Ratios {
  std::vector<int> vertices;
  Factors logs;                           ///< one row per entry of `vertices`
  Eigen::RowVector3d median = {0, 0, 0};  ///< zero when there are none
};

Ratios CompareVertices(const VertexColors& own, const VertexColors& other) {
  using Tuning = CompletionTuning;
  Ratios ratios;
  for (int v = 0; v < std::ssize(own.sure); ++v)
    if (own.sure[v] > Tuning::kBothSure && other.sure[v] > Tuning::kBothSure)
      ratios.vertices.push_back(v);
  ratios.logs.resize(std::ssize(ratios.vertices), 3);
  for (std::size_t i = 0; i < ratios.vertices.size(); ++i) {
    const int v = ratios.vertices[i];
    ratios.logs.row(i) = ((own.color[v].array() + Tuning::kDarkColor) /
                          (other.color[v].array() + Tuning::kDarkColor))
                             .log()
                             .matrix()
                             .transpose()
                             .cast<double>();
  }
  if (ratios.vertices.empty()) return ratios;
  for (int c = 0; c < 3; ++c) ratios.median[c] = UpperMedian(Eigen::VectorXd(ratios.logs.col(c)));
  return ratios;
}

Factors SmoothFactors(const Edges& edges, const Ratios& ratios,
                      const Eigen::VectorXd& inlier_weight, int vertex_count) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(vertex_count, kSmoothingGrain);
  Factors right = (kSmoothingGrain * ratios.median).replicate(vertex_count, 1);
  for (std::size_t i = 0; i < ratios.vertices.size(); ++i) {
    diagonal[ratios.vertices[i]] += CompletionTuning::kHold * inlier_weight[i];
    right.row(ratios.vertices[i]) +=
        CompletionTuning::kHold * inlier_weight[i] * ratios.logs.row(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [a, b] : edges) {
    diagonal[a] += 1;
    diagonal[b] += 1;
    entries.emplace_back(std::max(a, b), std::min(a, b), -1.0);
  }
  for (int v = 0; v < vertex_count; ++v) entries.emplace_back(v, v, diagonal[v]);
  Eigen::SparseMatrix<double> matrix(vertex_count, vertex_count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>(matrix).solve(right);
}

/// Rounds of least squares with robust weights (Cauchy) for vertices that differ from their
/// surroundings.
Factors FindFactors(const Edges& edges, const Ratios& ratios, int vertex_count) {
  using Tuning = CompletionTuning;
  Eigen::VectorXd inlier_weight(std::ssize(ratios.vertices));
  const auto weigh = [&](const auto& expected) {
    for (Eigen::Index i = 0; i < inlier_weight.size(); ++i)
      inlier_weight[i] = 1 / (1 + (ratios.logs.row(i) - expected(i)).squaredNorm() /
                                      (Tuning::kSameThing * Tuning::kSameThing));
  };
  weigh([&](Eigen::Index) { return ratios.median; });
  Factors factors;
  for (int round = 0; round < kRobustRounds; ++round) {
    factors = SmoothFactors(edges, ratios, inlier_weight, vertex_count);
    weigh([&](Eigen::Index i) { return Eigen::RowVector3d(factors.row(ratios.vertices[i])); });
  }
  return factors;
}

/// Confidence averaged over the surroundings: high well within the seen part, low at its border.
std::vector<float> Gathered(const Edges& edges, std::vector<float> sure) {
  for (int ring = 0; ring < CompletionTuning::kRings; ++ring) {
    std::vector<float> sum = sure, count(sure.size(), 1);
    for (const auto& [a, b] : edges) {
      sum[a] += sure[b];
      sum[b] += sure[a];
      ++count[a];
      ++count[b];
    }
    for (std::size_t v = 0; v < sure.size(); ++v) sure[v] = sum[v] / count[v];
  }
  return sure;
}

/// One of the other poses, prepared as a source.
struct SourcePose {
  Painting painting;
  Factors factors;              ///< one row per vertex
  std::vector<float> gathered;  ///< for each vertex
  int index = 0;                ///< in the given list
};

/// The best source for each vertex; -1: none.
std::vector<int> BestGivers(const std::vector<SourcePose>& givers, int vertex_count) {
  std::vector<int> best(vertex_count, -1);
  for (int v = 0; v < vertex_count; ++v)
    for (int g = 0; g < std::ssize(givers); ++g)
      if (givers[g].gathered[v] > (best[v] < 0 ? 0.0f : givers[best[v]].gathered[v])) best[v] = g;
  return best;
}

struct Filling {
  Vector3f color = Vector3f::Zero();
  float sure = 0;
  int giver = -1;  ///< the one with the largest share
};

class Filler {
 public:
  Filler(const Mesh& mesh, const Atlas& atlas, const std::vector<SourcePose>& givers)
      : mesh_(mesh),
        atlas_(atlas),
        givers_(givers),
        best_(BestGivers(givers, mesh.vertex_count())) {}

  /// The others' colour at a texel of the surface, in the own pose's light.
  Filling At(std::size_t texel) const {
    const Vector3f w = atlas_.Weights(texel);
    const auto face = mesh_.faces.row(atlas_.face[texel]);
    Filling filling;
    float sum = 0, most = 0;
    for (int g = 0; g < std::ssize(givers_); ++g) {
      // A source that is best at no corner is still used where the best ones show nothing.
      float share = 1e-4f;
      for (int k = 0; k < 3; ++k) share += best_[face[k]] == g ? std::max(w[k], 0.0f) : 0;
      const float sure = static_cast<float>(givers_[g].painting.sure[texel]) / 255,
                  part = share * sure;
      if (part <= 0) continue;
      filling.color += part * ColorOf(givers_[g], texel, w, face);
      filling.sure = std::max(filling.sure, sure);
      sum += part;
      if (part > most) {
        most = part;
        filling.giver = g;
      }
    }
    if (sum > 0) filling.color /= sum;
    return filling;
  }

 private:
  template <class Face>
  static Vector3f ColorOf(const SourcePose& giver, std::size_t texel, const Vector3f& w,
                          const Face& face) {
    Eigen::RowVector3d log = Eigen::RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) log += static_cast<double>(w[k]) * giver.factors.row(face[k]);
    const Vector3f factor = log.array().exp().matrix().transpose().cast<float>();
    // The factor applies to the colour plus the constant that was added to it, so that black stays
    // black.
    const float dark = CompletionTuning::kDarkColor;
    const Vector3f raised =
        ((giver.painting.At(texel).array() + dark) * factor.array() - dark).matrix();
    return raised.cwiseMax(0.0f).cwiseMin(1.0f);
  }

  const Mesh& mesh_;
  const Atlas& atlas_;
  const std::vector<SourcePose>& givers_;
  std::vector<int> best_;
};

/// Mixes the others' colours into the own painting.
/// @return for each texel its source; -1: its own or none
std::vector<int> Fill(const Atlas& atlas, const Filler& filler, Painting& own) {
  std::vector<int> from(own.sure.size(), -1);
  ParallelFor(
      std::ssize(own.sure),
      [&](std::int64_t texel) {
        if (atlas.face[texel] < 0 || own.sure[texel] == 255) return;
        const Filling filling = filler.At(texel);
        if (filling.sure <= 0) return;
        const float sure = static_cast<float>(own.sure[texel]) / 255,
                    mine = sure * sure * (3 - 2 * sure), theirs = (1 - mine) * filling.sure;
        if (theirs > mine) from[texel] = filling.giver;
        own.At(texel) = ((mine * own.At(texel) + theirs * filling.color) / (mine + theirs)).eval();
        own.sure[texel] = static_cast<std::uint8_t>(
            std::max(1L, std::lround(255 * std::max(sure, filling.sure))));
      },
      1 << 14);
  return from;
}

std::vector<SourcePose> GiversOf(const Mesh& mesh, const Atlas& atlas, const PoseTexture& own_pose,
                                 const Painting& own, const std::vector<PoseTexture>& others) {
  const Edges edges = UndirectedEdges(mesh.faces);
  const VertexColors mine = ReadVertices(mesh, atlas, own);
  std::vector<SourcePose> givers;
  for (std::size_t i = 0; i < others.size(); ++i) {
    RequireSquare(others[i], atlas.size, "texture " + std::to_string(i + 1) + " of the others");
    if (others[i].texture.data == own_pose.texture.data &&
        others[i].deep.data == own_pose.deep.data &&
        others[i].confidence.data == own_pose.confidence.data)
      continue;
    SourcePose giver{PaintingOf(others[i]), {}, {}, static_cast<int>(i)};
    const VertexColors theirs = ReadVertices(mesh, atlas, giver.painting);
    giver.factors = FindFactors(edges, CompareVertices(mine, theirs), mesh.vertex_count());
    giver.gathered = Gathered(edges, theirs.sure);
    givers.push_back(std::move(giver));
  }
  return givers;
}

}  // namespace

Completed CompleteTexture(const Mesh& mesh, const PoseTexture& own,
                          const std::vector<PoseTexture>& others, int gutter) {
  RequireUsable(mesh, "complete: mesh");
  const int size = ShapeOf(own).width;
  RequireSquare(own, size, "the pose's own texture");
  const Atlas atlas = RasterizeAtlas(mesh, size);
  Painting painting = PaintingOf(own);
  const std::vector<SourcePose> givers = GiversOf(mesh, atlas, own, painting, others);
  Completed completed;
  completed.texels = atlas.texels;
  completed.taken.assign(others.size(), 0);
  const std::vector<int> from = Fill(atlas, Filler(mesh, atlas, givers), painting);
  for (std::size_t texel = 0; texel < from.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    if (from[texel] >= 0) {
      ++completed.filled_texels;
      ++completed.taken[givers[from[texel]].index];
    }
    completed.own_texels += from[texel] < 0 && own.confidence.data[texel] > 0;
  }
  // Inpainted texels of the own bake are inpainted again.
  for (std::size_t texel = 0; texel < painting.sure.size(); ++texel)
    if (painting.sure[texel] == 0) painting.At(texel).setZero();
  InpaintUnseen(mesh, atlas, painting);
  completed.linear = FinishTexture(atlas, std::move(painting), gutter);
  completed.texture = SrgbImage(completed.linear);
  return completed;
}

}  // namespace keypose::texture
