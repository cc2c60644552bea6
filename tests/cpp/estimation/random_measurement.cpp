#include "estimation/random_measurement.hpp"

#include <Eigen/Cholesky>

namespace truenorth {

RandomMeasurement::RandomMeasurement(RandomCovariance& random, double size)
    : P(random.covariance<kStates>(0.05, 5.0)),
      H(random.normal<kChannels, kStates>()),
      R(random.normal<kChannels, 1>().cwiseAbs2() + Channels::Constant(0.05)) {
    const Dense root = Dense(S()).llt().matrixL();
    residual = size * root * random.normal(kChannels, 1);
}

Innovation<kStates, kChannels> RandomMeasurement::innovation() const {
    return innovation_of<kStates, kChannels>(P, H, R.asDiagonal(), residual);
}

Matrix<kChannels> RandomMeasurement::S() const {
    const Dense h = H;
    Dense sum = h * Dense(P) * h.transpose();
    sum.diagonal() += R;
    return sum;
}

DenseUpdate::DenseUpdate(const Dense& P, const Dense& H, const Eigen::VectorXd& R,
                         const Eigen::VectorXd& residual, const std::vector<int>& rows) {
    const Dense h = H(rows, Eigen::all);
    S = h * P * h.transpose();
    S.diagonal() += Eigen::VectorXd(R(rows));
    const Dense K = P * h.transpose() * inverse(S);
    deviation = K * residual(rows);
    covariance = P - K * S * K.transpose();
}

}  // namespace truenorth
