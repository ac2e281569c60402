#!/bin/sh
# Build the board's attitude controller from the lab's public sources, without a change of them.
#
#   tools/lab_stack/build.sh SOURCES OUT
#
# SOURCES is a checkout of jsk_aerial_robot; OUT/board is made. Debian 12 needs: g++ libroscpp-dev libtf-dev
# libstd-srvs-dev python3-gencpp python3-rosmaster.
set -eu
here=$(dirname "$(readlink -f "$0")")
spinal=$1/aerial_robot_nerve/spinal
firmware=$spinal/mcu_project/lib/Jsk_Lib
mkdir -p "$2/messages/spinal"
for file in "$spinal"/msg/*.msg "$spinal"/srv/*.srv; do
  /usr/bin/python3 /usr/lib/gencpp/gen_cpp.py "$file" -I std_msgs:/usr/share/std_msgs/msg \
    -I geometry_msgs:/usr/share/geometry_msgs/msg -I "spinal:$spinal/msg" \
    -p spinal -o "$2/messages/spinal" -e /usr/share/gencpp
done
math=$firmware/math
# The sources take a few headers of boost for granted.
g++ -std=c++17 -O1 -DNDEBUG -DSIMULATION -DBOOST_BIND_GLOBAL_PLACEHOLDERS -w \
  -include boost/thread/lock_guard.hpp -include boost/thread/mutex.hpp -include boost/bind.hpp \
  -I"$2/messages" -I"$firmware" "$here/board.cpp" "$firmware/flight_control/attitude/attitude_control.cpp" \
  "$math/AP_Math.cpp" "$math/matrix3.cpp" "$math/vector3.cpp" "$math/vector2.cpp" "$math/quaternion.cpp" \
  "$math/location.cpp" -lroscpp -lrosconsole -lrostime -lroscpp_serialization -lboost_system -lboost_thread \
  -lpthread -lxmlrpcpp -o "$2/board"
