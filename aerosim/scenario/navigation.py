"""Section `navigation`: satellite and inertial devices, and the smoother of their record."""

from __future__ import annotations

from pydantic import Field

from aerosim.scenario.section import NotNegative, Section


class Gnss(Section):
    """Satellite positions."""

    period_s: float = Field(default=0.6, gt=0, le=3600, description="time between fixes")
    sigma_m: tuple[NotNegative, NotNegative, NotNegative] = Field(
        default=(0.02, 0.02, 0.03), description="standard deviation north, east, down"
    )
    velocity_sigma_m_s: float = Field(
        default=0.03, ge=0, le=100, description="standard deviation of each component of the velocity"
    )
    delay_s: float = Field(default=0.0, ge=0, le=60, description="from the fix to its arrival")
    lever_arm_m: tuple[float, float, float] = Field(
        default=(0.0, 0.0, -1.5), description="antenna from the centre of gravity: forward, right, down"
    )


class Ins(Section):
    """Attitude of an inertial system."""

    period_s: float = Field(default=0.1, gt=0, le=3600, description="time between readings")
    sigma_deg: float = Field(default=0.003, ge=0, le=90, description="white noise of each angle")
    drift_deg_per_h: float = Field(default=0.01, ge=0, le=3600, description="standard deviation of the drift rate")
    boresight_deg: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0), description="camera against the unit: roll, pitch, yaw"
    )


class Imu(Section):
    """Gyroscopes and accelerometers that aid the estimator."""

    period_s: float = Field(default=0.05, gt=0, le=3600, description="time between readings")
    gyro_noise_deg: float = Field(default=0.014, ge=0, le=90, description="white noise of each integrated angle")
    gyro_bias_deg_per_h: float = Field(default=10.0, ge=0, le=100000, description="standard deviation of the bias")
    accel_noise_m_s2: float = Field(default=0.005, ge=0, le=100, description="white noise of each axis")
    accel_bias_m_s2: float = Field(default=0.001, ge=0, le=100, description="standard deviation of the bias")
    level_error_deg: float = Field(default=0.1, ge=0, le=90, description="standard deviation of roll and pitch")
    level_time_s: float = Field(default=60.0, gt=0, le=100000, description="time constant of that error")


class Smooth(Section):
    """Orders of the ARI process that smooths the record."""

    p: int = Field(default=2, ge=0, le=20, description="order of the autoregression")
    d: int = Field(default=2, ge=0, le=4, description="order of the integration")


class Navigation(Section):
    """Navigation devices; each may be absent (null)."""

    gnss: Gnss | None = Field(default=Gnss(), description="satellite positions; null: none")
    ins: Ins | None = Field(default=Ins(), description="inertial attitude; null: none")
    imu: Imu | None = Field(default=Imu(), description="gyroscopes and accelerometers; null: none")
    smooth: Smooth | None = Field(default=None, description="ARI smoothing of the record; null: none")
