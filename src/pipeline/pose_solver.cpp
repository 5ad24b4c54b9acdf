#include "pipeline/pose_solver.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "srslam/core/orthonormalized.hpp"
#include "srslam/core/robust_cost.hpp"
#include "srslam/core/se3.hpp"

namespace srslam::detail {
namespace {

constexpr int kRounds = 4;
constexpr int kIterationsPerRound = 10;
constexpr double kMinStep = 1e-7;
// A point this close to the image plane has no meaningful projection.
constexpr double kMinZ_m = 1e-3;

struct NormalEquations {
  Eigen::Matrix<double, 6, 6> hessian;
  Eigen::Matrix<double, 6, 1> gradient;
  double cost = 0.0;
  int num_used = 0;
};

/// Whitened residual (pixel u, v and disparity, the last 0 without depth); false behind the camera.
bool residual_at(const TrackingCamera& camera, const Eigen::Matrix3d& R_camera_world,
                 const Eigen::Vector3d& t_camera_world, const PoseObservation& observation,
                 Eigen::Vector3d* point_camera_m, Eigen::Vector3d* residual) {
  *point_camera_m = R_camera_world * observation.position_m + t_camera_world;
  if (!(point_camera_m->z() > kMinZ_m)) return false;
  const Eigen::Vector3d predicted = camera.project(*point_camera_m);
  const Measurement& measured = observation.measurement;
  (*residual)[0] = (predicted.x() - measured.pixel.x()) * observation.inverse_sigma;
  (*residual)[1] = (predicted.y() - measured.pixel.y()) * observation.inverse_sigma;
  (*residual)[2] = measured.has_depth()
                       ? (predicted.z() - measured.disparity_px) * observation.inverse_sigma
                       : 0.0;
  return true;
}

/// `robust` off: plain least squares over the inliers.
NormalEquations build(const TrackingCamera& camera, const Pose& T_world_camera,
                      const std::vector<PoseObservation>& observations, bool robust) {
  const RobustCost huber_pixel{RobustKind::kHuber, std::sqrt(kChi2Pixel)};
  const RobustCost huber_depth{RobustKind::kHuber, std::sqrt(kChi2PixelDepth)};
  const Eigen::Matrix3d R_camera_world = T_world_camera.linear().transpose();
  const Eigen::Vector3d t_camera_world = -(R_camera_world * T_world_camera.translation());
  NormalEquations equations;
  equations.hessian.setZero();
  equations.gradient.setZero();
  Eigen::Vector3d point_m;
  Eigen::Vector3d residual;
  for (const PoseObservation& observation : observations) {
    if (!observation.inlier) continue;
    if (!residual_at(camera, R_camera_world, t_camera_world, observation, &point_m, &residual)) {
      continue;
    }
    const bool has_depth = observation.measurement.has_depth();
    const double squared = residual.squaredNorm();
    const RobustCost& huber = has_depth ? huber_depth : huber_pixel;
    const double weight = robust ? huber.weight(squared) : 1.0;
    equations.cost += robust ? huber.rho(squared) : squared;
    ++equations.num_used;

    // d p_camera / d(perturbation on the camera's side) = [-I | hat(p_camera)].
    const double inverse_z = 1.0 / point_m.z();
    const double x = point_m.x() * inverse_z;
    const double y = point_m.y() * inverse_z;
    const double s = observation.inverse_sigma;
    const double fu = camera.fx * inverse_z * s;
    const double fv = camera.fy * inverse_z * s;
    Eigen::Matrix<double, 3, 6> J;
    J.row(0) << -fu, 0.0, fu * x, fu * x * point_m.y(), -fu * (point_m.z() + x * point_m.x()),
        fu * point_m.y();
    J.row(1) << 0.0, -fv, fv * y, fv * (point_m.z() + y * point_m.y()), -fv * y * point_m.x(),
        -fv * point_m.x();
    if (has_depth) {
      const double fd = camera.baseline_fx * inverse_z * inverse_z * s;
      J.row(2) << 0.0, 0.0, fd, fd * point_m.y(), -fd * point_m.x(), 0.0;
    } else {
      J.row(2).setZero();
    }
    equations.hessian.noalias() += weight * (J.transpose() * J);
    equations.gradient.noalias() += weight * (J.transpose() * residual);
  }
  return equations;
}

int classify(const TrackingCamera& camera, const Pose& T_world_camera,
             std::vector<PoseObservation>* observations) {
  const Eigen::Matrix3d R_camera_world = T_world_camera.linear().transpose();
  const Eigen::Vector3d t_camera_world = -(R_camera_world * T_world_camera.translation());
  int num_inliers = 0;
  Eigen::Vector3d point_m;
  Eigen::Vector3d residual;
  for (PoseObservation& observation : *observations) {
    const double gate = observation.measurement.has_depth() ? kChi2PixelDepth : kChi2Pixel;
    observation.inlier =
        residual_at(camera, R_camera_world, t_camera_world, observation, &point_m, &residual) &&
        residual.squaredNorm() <= gate;
    if (observation.inlier) ++num_inliers;
  }
  return num_inliers;
}

/// Whether the equations have one solution. Judged without damping, which hides a free direction,
/// and by a unit diagonal, so that metres and radians weigh the same.
bool determines_pose(const Matrix6& information) {
  constexpr double kMinPivot = 1e-10;  // roundings, which the other pivots magnify, reach 1e-12
  const Vector6 diagonal = information.diagonal();
  if (!(diagonal.minCoeff() > 0.0)) return false;
  const Vector6 scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, 6, 6> scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(scaled);
  return factor.info() == Eigen::Success && factor.vectorD().minCoeff() > kMinPivot;
}

}  // namespace

PoseSolution solve_pose(const TrackingCamera& camera, const Pose& T_world_camera_guess,
                        std::vector<PoseObservation>* observations) {
  PoseSolution solution;
  solution.T_world_camera = T_world_camera_guess;
  if (observations->size() < 3) {
    solution.status =
        Status::failure(StatusCode::kInsufficientData, "a pose needs at least three observations");
    return solution;
  }
  for (PoseObservation& observation : *observations) observation.inlier = true;
  for (int round = 0; round < kRounds; ++round) {
    // The last round trusts the gate: the Huber cost would pull towards borderline outliers.
    const bool robust = round + 1 < kRounds;
    NormalEquations equations = build(camera, solution.T_world_camera, *observations, robust);
    double damping = 1e-6;
    for (int iteration = 0; iteration < kIterationsPerRound; ++iteration) {
      if (equations.num_used < 3) {
        solution.status =
            Status::failure(StatusCode::kInsufficientData, "fewer than three inliers are left");
        solution.num_inliers = 0;
        return solution;
      }
      Eigen::Matrix<double, 6, 6> damped = equations.hessian;
      damped.diagonal() *= 1.0 + damping;
      const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(damped);
      if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 1e-9)) {
        solution.status =
            Status::failure(StatusCode::kDegenerate, "the observations do not determine a pose");
        return solution;
      }
      const Eigen::Matrix<double, 6, 1> step = -factor.solve(equations.gradient);
      const Pose stepped = solution.T_world_camera * se3_exp(step);
      const NormalEquations next = build(camera, stepped, *observations, robust);
      // Points that a step pushes behind the camera leave the sum; that is no improvement.
      if (next.num_used >= equations.num_used && next.cost <= equations.cost) {
        const bool converged =
            step.norm() < kMinStep || equations.cost - next.cost < 1e-6 * equations.cost;
        solution.T_world_camera = stepped;
        equations = next;
        damping = std::max(damping * 0.1, 1e-9);
        if (converged) break;
      } else {
        if (step.norm() < kMinStep) break;
        damping *= 100.0;
      }
    }
    solution.information = equations.hessian;
    solution.num_inliers = classify(camera, solution.T_world_camera, observations);
  }
  if (solution.num_inliers < 3) {
    solution.status =
        Status::failure(StatusCode::kInsufficientData, "fewer than three inliers are left");
    return solution;
  }
  if (!determines_pose(solution.information)) {
    solution.status =
        Status::failure(StatusCode::kDegenerate, "the observations do not determine a pose");
    return solution;
  }
  solution.T_world_camera = orthonormalized(solution.T_world_camera);
  solution.status = Status::success();
  return solution;
}

}  // namespace srslam::detail
