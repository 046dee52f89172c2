#include "deform/solvers/dense_product.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::dense_product_test {

template <class Matrix>
Matrix Filled(Eigen::Index rows, Eigen::Index columns, int seed) {
  Matrix m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i)
    m.data()[i] = static_cast<typename Matrix::Scalar>((7 * i + seed) % 11 - 5);
  return m;
}

/// Small whole numbers, so that both ways are exact.
template <class Matrix>
void ExpectProducts() {
  const Matrix a = Filled<Matrix>(4, 3, 1), b = Filled<Matrix>(3, 5, 2);
  const Matrix old = Filled<Matrix>(4, 5, 3);
  Matrix product = old;
  Multiply(2, a, b, Flip::kNone, 0, product);
  EXPECT_EQ(product, Matrix(2 * a.lazyProduct(b)));
  product = old;
  Multiply(-1, Matrix(a.transpose()), b, Flip::kFirst, 1, product);
  EXPECT_EQ(product, Matrix(old - a.lazyProduct(b)));
  product = old;
  Multiply(1, a, Matrix(b.transpose()), Flip::kSecond, 3, product);
  EXPECT_EQ(product, Matrix(3 * old + a.lazyProduct(b)));
}

TEST(Multiply, IsEigensProductInBothPrecisionsForEachFlip) {
  ExpectProducts<Eigen::MatrixXd>();
  ExpectProducts<Eigen::MatrixXf>();
}

TEST(Multiply, WithoutKeepingOldValuesMayBeAnything) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(2, 2);
  Eigen::MatrixXd product = Eigen::MatrixXd::Constant(2, 2, std::nan(""));
  Multiply(1, a, a, Flip::kNone, 0, product);
  EXPECT_EQ(product, a);
}

}  // namespace keypose::dense_product_test
