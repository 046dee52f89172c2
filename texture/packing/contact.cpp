#include "texture/packing/contact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/numbers/parallel.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;

constexpr int kMostTouched = 8;  // outlines near one vertex

struct OutlineEdge {
  int rim, from, to;
};

// Edges in square buckets as wide as the reach.
class Buckets {
 public:
  Buckets(const std::vector<UvsX2>& rims, double reach)
      : n_(std::clamp(static_cast<int>(1 / reach), 1, 256)) {
    for (int r = 0; r < std::ssize(rims); ++r)
      for (int i = 0, n = static_cast<int>(rims[r].rows()); i < n; ++i)
        edges_.push_back({r, i, (i + 1) % n});
    std::vector<std::array<int, 4>> boxes;
    start_.assign(static_cast<std::size_t>(n_) * n_ + 1, 0);
    for (const OutlineEdge& e : edges_) {
      const Eigen::RowVector2d a = rims[e.rim].row(e.from), b = rims[e.rim].row(e.to);
      boxes.push_back({Cell(std::min(a.x(), b.x())), Cell(std::max(a.x(), b.x())),
                       Cell(std::min(a.y(), b.y())), Cell(std::max(a.y(), b.y()))});
      ForCells(boxes.back(), [&](std::size_t c) { ++start_[c + 1]; });
    }
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    items_.resize(start_.back());
    std::vector<int> at(start_.begin(), start_.end() - 1);
    for (int e = 0; e < std::ssize(edges_); ++e)
      ForCells(boxes[e], [&](std::size_t c) { items_[at[c]++] = e; });
  }

  template <typename Visit>
  void Near(const Vector2d& p, double reach, const Visit& visit) const {
    ForCells({Cell(p.x() - reach), Cell(p.x() + reach), Cell(p.y() - reach), Cell(p.y() + reach)},
             [&](std::size_t c) {
               for (int i = start_[c]; i < start_[c + 1]; ++i) visit(edges_[items_[i]]);
             });
  }

 private:
  int Cell(double x) const { return std::clamp(static_cast<int>(std::floor(x * n_)), 0, n_ - 1); }
  template <typename Body>
  void ForCells(const std::array<int, 4>& box, const Body& body) const {
    for (int y = box[2]; y <= box[3]; ++y)
      for (int x = box[0]; x <= box[1]; ++x) body(static_cast<std::size_t>(y) * n_ + x);
  }

  int n_;
  std::vector<OutlineEdge> edges_;
  std::vector<int> start_, items_;
};

// The nearest point of another outline.
struct Touch {
  int rim = -1, from = 0, to = 0;
  double t = 0, squared = 0;
};

Vector2d OutwardAt(const UvsX2& rim, const Touch& touch) {
  const auto outward = [&](Eigen::Index i) -> Vector2d {
    const Eigen::RowVector2d e = rim.row((i + 1) % rim.rows()) - rim.row(i);
    return Vector2d(e.y(), -e.x()) / std::max(e.norm(), 1e-300);
  };
  const Eigen::Index n = rim.rows();
  if (touch.t <= 0) return outward(touch.from) + outward((touch.from + n - 1) % n);
  if (touch.t >= 1) return outward(touch.from) + outward(touch.to);
  return outward(touch.from);
}

struct Contact {
  Touch touch;
  Vector2d push;  // of the vertex; the edge gets the opposite
};

struct VertexContacts {
  std::array<Contact, kMostTouched> contacts;
  int count = 0;
  Vector2d border = Vector2d::Zero();
  double least = 0;
};

class Finder {
 public:
  Finder(const std::vector<UvsX2>& rims, double gap, double reach)
      : rims_(rims), buckets_(rims, reach), gap_(gap), reach_(reach) {}

  VertexContacts At(int rim, int vertex) const {
    VertexContacts out;
    out.least = reach_;
    const Vector2d p = rims_[rim].row(vertex).transpose();
    Border(p, out);
    std::array<Touch, kMostTouched> touches;
    int count = 0;
    buckets_.Near(p, reach_, [&](const OutlineEdge& e) {
      if (e.rim == rim) {
        if (e.from == vertex || e.to == vertex) return;
      }
      Take(p, e, touches, count);
    });
    for (int i = 0; i < count; ++i) Judge(p, rim, vertex, touches[i], out);
    return out;
  }

 private:
  void Border(const Vector2d& p, VertexContacts& out) const {
    for (int k = 0; k < 2; ++k) {
      const double low = p[k] - gap_ / 2, high = 1 - gap_ / 2 - p[k];
      if (low < 0) out.border[k] = -low;
      if (high < 0) out.border[k] = high;
      out.least = std::min(out.least, 2 * std::min(p[k], 1 - p[k]));
    }
  }

  void Take(const Vector2d& p, const OutlineEdge& e, std::array<Touch, kMostTouched>& touches,
            int& count) const {
    const Vector2d a = rims_[e.rim].row(e.from).transpose(),
                   d = rims_[e.rim].row(e.to).transpose() - a;
    const double t = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    const double squared = (a + t * d - p).squaredNorm();
    if (squared > reach_ * reach_) return;
    int i = 0;
    while (i < count && touches[i].rim != e.rim) ++i;
    if (i == count) {
      if (count == kMostTouched) return;
      touches[count++] = {e.rim, e.from, e.to, t, squared};
    } else if (squared < touches[i].squared ||
               (squared == touches[i].squared && e.from < touches[i].from)) {
      touches[i] = {e.rim, e.from, e.to, t, squared};
    }
  }

  void Judge(const Vector2d& p, int rim, int vertex, const Touch& touch,
             VertexContacts& out) const {
    const UvsX2& other = rims_[touch.rim];
    const Vector2d a = other.row(touch.from).transpose(),
                   foot = a + touch.t * (other.row(touch.to).transpose() - a);
    const Vector2d outward = OutwardAt(other, touch);
    const double side = (p - foot).dot(outward), distance = std::sqrt(touch.squared);
    if (touch.rim == rim) {
      // Across its own bay an outline is near itself from outside; across a neck from inside, which
      // is no contact.
      const Touch here{rim, vertex, (vertex + 1) % static_cast<int>(other.rows()), 0, 0};
      const int n = static_cast<int>(other.rows());
      int end = -1;
      if (touch.t >= 1) end = touch.to;
      if (touch.t <= 0) end = touch.from;
      if (end >= 0 && ((end + 1) % n == vertex || (vertex + 1) % n == end)) return;
      if (side <= 0 || (foot - p).dot(OutwardAt(other, here)) <= 0 || distance >= gap_ / 2) return;
      out.contacts[out.count++] = {
          touch, (p - foot) / std::max(distance, 1e-300) * ((gap_ / 2 - distance) / 2)};
      return;
    }
    const double signed_gap = side > 0 ? distance : -distance;
    out.least = std::min(out.least, signed_gap);
    if (signed_gap >= gap_) return;
    const Vector2d direction =
        distance > 1e-12 ? Vector2d((p - foot) / signed_gap) : Vector2d(outward.normalized());
    out.contacts[out.count++] = {touch, direction * ((gap_ - signed_gap) / 2)};
  }

  const std::vector<UvsX2>& rims_;
  Buckets buckets_;
  double gap_, reach_;
};

}  // namespace

Contacts FindContacts(const std::vector<UvsX2>& rims, double gap, double reach) {
  const Finder finder(rims, gap, reach);
  std::vector<std::vector<VertexContacts>> found(rims.size());
  ParallelFor(std::ssize(rims), [&](std::int64_t r) {
    for (int v = 0; v < static_cast<int>(rims[r].rows()); ++v)
      found[r].push_back(finder.At(static_cast<int>(r), v));
  });
  Contacts out;
  out.least_gap = reach;
  std::vector<std::vector<double>> weight;
  for (const UvsX2& rim : rims) {
    out.push.push_back(UvsX2::Zero(rim.rows(), 2));
    weight.emplace_back(rim.rows(), 0.0);
  }
  // Sequentially, so that sums have the same bits.
  for (std::size_t r = 0; r < rims.size(); ++r) {
    for (std::size_t v = 0; v < found[r].size(); ++v) {
      const VertexContacts& at = found[r][v];
      out.least_gap = std::min(out.least_gap, at.least);
      for (int i = 0; i < at.count; ++i) {
        const auto& [touch, push] = at.contacts[i];
        out.push[r].row(v) += push.transpose();
        weight[r][v] += 1;
        out.push[touch.rim].row(touch.from) -= (1 - touch.t) * push.transpose();
        out.push[touch.rim].row(touch.to) -= touch.t * push.transpose();
        weight[touch.rim][touch.from] += 1 - touch.t;
        weight[touch.rim][touch.to] += touch.t;
      }
    }
  }
  for (std::size_t r = 0; r < rims.size(); ++r)
    for (std::size_t v = 0; v < found[r].size(); ++v)
      out.push[r].row(v) =
          out.push[r].row(v) / std::max(weight[r][v], 1.0) + found[r][v].border.transpose();
  return out;
}

bool AnyCross(const std::vector<UvsX2>& rims) {
  struct Segment {
    double left, right;
    int rim;
    Vector2d a, b;
  };
  std::vector<Segment> segments;
  for (int r = 0; r < std::ssize(rims); ++r) {
    for (Eigen::Index i = 0; i < rims[r].rows(); ++i) {
      const Vector2d a = rims[r].row(i).transpose(),
                     b = rims[r].row((i + 1) % rims[r].rows()).transpose();
      segments.push_back({std::min(a.x(), b.x()), std::max(a.x(), b.x()), r, a, b});
    }
  }
  std::stable_sort(segments.begin(), segments.end(),
                   [](const Segment& p, const Segment& q) { return p.left < q.left; });
  const auto turn = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 0;
  };
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& p = segments[i];
    for (std::size_t j = i + 1; j < segments.size() && segments[j].left <= p.right; ++j) {
      const Segment& q = segments[j];
      if (p.rim == q.rim || std::max(p.a.y(), p.b.y()) < std::min(q.a.y(), q.b.y()) ||
          std::max(q.a.y(), q.b.y()) < std::min(p.a.y(), p.b.y()))
        continue;
      if (turn(p.a, p.b, q.a) != turn(p.a, p.b, q.b) && turn(q.a, q.b, p.a) != turn(q.a, q.b, p.b))
        return true;
    }
  }
  return false;
}

}  // namespace keypose::texture
