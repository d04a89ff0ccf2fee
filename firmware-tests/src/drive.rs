//! What is on the bus of the board: drives of either family.

use drive_sim::{Device, DynDrive, Frame, ZlacDrive};

/// A simulated drive.
#[derive(Debug, Clone)]
pub enum Drive {
    /// A DYN servo drive.
    Servo(Box<DynDrive>),
    /// A ZLAC8030L hub-motor drive.
    HubMotor(Box<ZlacDrive>),
}

impl Drive {
    fn device(&self) -> &dyn Device {
        match self {
            Self::Servo(drive) => drive,
            Self::HubMotor(drive) => drive,
        }
    }

    fn device_mut(&mut self) -> &mut dyn Device {
        match self {
            Self::Servo(drive) => drive,
            Self::HubMotor(drive) => drive,
        }
    }

    /// The servo drive, if it is one.
    #[must_use]
    pub fn servo(&self) -> Option<&DynDrive> {
        match self {
            Self::Servo(drive) => Some(drive),
            Self::HubMotor(_) => None,
        }
    }

    /// The servo drive to change it, if it is one.
    pub fn servo_mut(&mut self) -> Option<&mut DynDrive> {
        match self {
            Self::Servo(drive) => Some(drive),
            Self::HubMotor(_) => None,
        }
    }

    /// The hub-motor drive, if it is one.
    #[must_use]
    pub fn hub_motor(&self) -> Option<&ZlacDrive> {
        match self {
            Self::Servo(_) => None,
            Self::HubMotor(drive) => Some(drive),
        }
    }

    /// The hub-motor drive to change it, if it is one.
    pub fn hub_motor_mut(&mut self) -> Option<&mut ZlacDrive> {
        match self {
            Self::Servo(_) => None,
            Self::HubMotor(drive) => Some(drive),
        }
    }
}

impl From<DynDrive> for Drive {
    fn from(drive: DynDrive) -> Self {
        Self::Servo(Box::new(drive))
    }
}

impl From<ZlacDrive> for Drive {
    fn from(drive: ZlacDrive) -> Self {
        Self::HubMotor(Box::new(drive))
    }
}

impl Device for Drive {
    fn on_frame(&mut self, now_ns: u64, frame: &Frame) {
        self.device_mut().on_frame(now_ns, frame);
    }

    fn next_event_ns(&self) -> Option<u64> {
        self.device().next_event_ns()
    }

    fn run(&mut self, now_ns: u64, transmit: &mut dyn FnMut(Frame)) {
        self.device_mut().run(now_ns, transmit);
    }
}
