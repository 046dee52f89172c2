#include "deform/solvers/dense_product.h"

#include <cblas.h>

#include "core/numbers/blas_threads.h"

namespace keypose {

namespace {

template <class Gemm, class Scalar, class Factor, class Product>
void Call(const Gemm& gemm, Scalar factor, const Factor& a, const Factor& b, Flip flip, Scalar keep,
          Product& product) {
  UseOneBlasThread();
  const auto transposed = [flip](Flip which) { return flip == which ? CblasTrans : CblasNoTrans; };
  const auto number = [](Eigen::Index i) { return static_cast<blasint>(i); };
  gemm(CblasColMajor, transposed(Flip::kFirst), transposed(Flip::kSecond), number(product.rows()),
       number(product.cols()), number(flip == Flip::kFirst ? a.rows() : a.cols()), factor, a.data(),
       number(a.outerStride()), b.data(), number(b.outerStride()), keep, product.data(),
       number(product.outerStride()));
}

}  // namespace

void Multiply(float factor, const Eigen::Ref<const Eigen::MatrixXf>& a,
              const Eigen::Ref<const Eigen::MatrixXf>& b, Flip flip, float keep,
              Eigen::Ref<Eigen::MatrixXf> product) {
  Call(cblas_sgemm, factor, a, b, flip, keep, product);
}

void Multiply(double factor, const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Flip flip, double keep,
              Eigen::Ref<Eigen::MatrixXd> product) {
  Call(cblas_dgemm, factor, a, b, flip, keep, product);
}

}  // namespace keypose
