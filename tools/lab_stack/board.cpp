// The lab's attitude controller, compiled for a computer, fed with cases from stdin; thrusts to stdout.
//
// The first word of the command line is gimbal_dof, 0 where there is none; base thrusts, gains and rows of matrices
// then stand for each component of a rotor's force.
//
// A case is a line: how many entries the gains have, the gains, rows of the pseudo-inverse, inertia, rows of the torque
// inverse, desired roll pitch yaw, angles and base thrusts of the command, quaternion w x y z, rates, integrals of roll
// and pitch. A line of the answer: four thrusts, the gimbals' angles, and whether it lands by force.
#include <iostream>

#include <ros/ros.h>
#include <sensor_msgs/JointState.h>
#include <spinal/DesireCoord.h>
#include <spinal/Imu.h>
#include <spinal/RollPitchYawTerm.h>
#include <std_msgs/Float32MultiArray.h>
#include <std_msgs/UInt8.h>
#include <std_srvs/SetBool.h>
#include <sstream>

#define private public
#include "flight_control/flight_control.h"
#undef private

namespace {
int gimbal_dof = 0;
// The board has room for ten components: of four rotors with three each some would lie in other memory.
int rotors() { return gimbal_dof < 2 ? 4 : 3; }
int entries() { return rotors() * (gimbal_dof + 1); }

double next() {
  double value;
  if (!(std::cin >> value)) throw std::runtime_error("a case is too short");
  return value;
}

void arm(FlightControl& flight, bool on) {
  spinal::FlightConfigCmd command;
  command.cmd = on ? 0 : 1;
  flight.flightConfigCallback(command);
}

void describe(FlightControl& flight, AttitudeController& board) {
  spinal::PwmInfo motors;
  motors.min_pwm = 0.58;
  motors.max_pwm = 0.92;
  motors.min_thrust = 1.0;
  motors.force_landing_thrust = 7.0;
  spinal::MotorInfo motor;
  motor.voltage = 25.2;
  motor.max_thrust = 33.0;
  motor.polynominal[1] = -5.342;
  motor.polynominal[2] = 0.0976;
  motors.motor_info.push_back(motor);
  board.pwmInfoCallback(motors);
  std_msgs::UInt8 dof;
  dof.data = gimbal_dof;
  flight.gimbalDofCallback(dof);
  spinal::UavInfo uav;
  uav.motor_num = rotors();
  uav.uav_model = 17;
  flight.uavInfoConfigCallback(uav);
}

void take(AttitudeController& board) {
  spinal::RollPitchYawTerms gains;
  gains.motors.resize(static_cast<int>(next()));
  for (auto& one : gains.motors) {
    one.roll_p = next(), one.roll_i = next(), one.roll_d = next();
    one.pitch_p = next(), one.pitch_i = next(), one.pitch_d = next(), one.yaw_d = next();
  }
  board.rpyGainCallback(gains);
  spinal::PMatrixPseudoInverseWithInertia matrix;
  matrix.pseudo_inverse.resize(entries());
  for (auto& row : matrix.pseudo_inverse) row.r = next(), row.p = next(), row.y = next();
  for (auto& entry : matrix.inertia) entry = next();
  board.pMatrixInertiaCallback(matrix);
  spinal::TorqueAllocationMatrixInv inverse;
  inverse.rows.resize(entries());
  for (auto& row : inverse.rows) row.x = next(), row.y = next(), row.z = next();
  if (gains.motors.size() == 1) board.torqueAllocationMatrixInvCallback(inverse);
  spinal::DesireCoord desired;
  desired.roll = next(), desired.pitch = next(), desired.yaw = next();
  board.offsetRotCallback(desired);
}
}  // namespace

int main(int count, char** words) {
  if (count > 1) gimbal_dof = std::stoi(words[1]);
  ros::init(count, words, "board");
  ros::NodeHandle node("/board");
  StateEstimate estimate;
  estimate.init(&node);
  estimate.getAttEstimator()->useGroundTruth(true);
  FlightControl flight;
  flight.init(&node, &estimate);
  AttitudeController& board = flight.att_controller_;
  describe(flight, board);
  std::cout.precision(9);
  for (int cases = static_cast<int>(next()); cases > 0; --cases) {
    arm(flight, false);
    arm(flight, true);
    board.setForceLandingFlag(false);
    take(board);
    spinal::FourAxisCommand command;
    for (auto& angle : command.angles) angle = next();
    command.base_thrust.resize(entries());
    for (auto& thrust : command.base_thrust) thrust = next();
    float turn[4], rates[3];
    for (auto& entry : turn) entry = next();
    for (auto& entry : rates) entry = next();
    for (int axis = 0; axis < 2; ++axis) board.error_angle_i_[axis] = next();
    ap::Matrix3f rotation;
    ap::Quaternion(turn[0], turn[1], turn[2], turn[3]).rotation_matrix(rotation);
    estimate.getAttEstimator()->setGroundTruthStates(rotation, ap::Vector3f(rates[0], rates[1], rates[2]));
    for (int i = 0; i < rotors() * gimbal_dof; ++i) board.target_gimbal_angles_[i] = 0.0;
    board.fourAxisCommandCallback(command);
    board.update();
    for (int rotor = 0; rotor < rotors(); ++rotor) std::cout << board.getForce(rotor) << ' ';
    for (int i = 0; i < rotors() * gimbal_dof; ++i) std::cout << board.target_gimbal_angles_[i] << ' ';
    std::cout << board.getForceLandingFlag() << '\n';
  }
}
