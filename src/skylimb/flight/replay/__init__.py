"""A recorded flight through estimator and controller again, open loop: no simulator, no robot.

    log -> what was measured and commanded -> estimator and controller -> what they would have made of it

With the configuration that flew, the recorded estimates and commands come out again. With another one, what
would have been estimated and commanded stands beside what was. The estimator always gets the thrusts that
were really flown: a wrench is found by comparing them with the motion.
"""
