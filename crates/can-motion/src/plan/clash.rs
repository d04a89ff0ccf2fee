//! Which identifiers mean something in both protocols, for the axes of a bus.

use dyn_can::{Address, FunctionCode};

use super::canopen::{Canopen, CanopenService, Clash};
use crate::servo::config::AxisConfig;

const NODE_SERVICES: [(u16, CanopenService); 12] = [
    (0x080, CanopenService::Emergency),
    (0x180, CanopenService::Pdo),
    (0x200, CanopenService::Pdo),
    (0x280, CanopenService::Pdo),
    (0x300, CanopenService::Pdo),
    (0x380, CanopenService::Pdo),
    (0x400, CanopenService::Pdo),
    (0x480, CanopenService::Pdo),
    (0x500, CanopenService::Pdo),
    (0x580, CanopenService::Sdo),
    (0x600, CanopenService::Sdo),
    (0x700, CanopenService::Heartbeat),
];

impl Canopen {
    /// The first identifier that one of these axes, or every drive, would take for its own.
    #[must_use]
    pub const fn clash(&self, axes: &[AxisConfig]) -> Option<Clash> {
        if self.uses_nmt {
            // Broadcast Set_Origin: it concerns every drive.
            return Some(Clash::new(0x000, CanopenService::Nmt, 0));
        }
        if self.uses_sync {
            let clash = Clash::new(0x080, CanopenService::Sync, 0);
            if clash.concerns(axes) {
                return Some(clash);
            }
        }
        let mut rest = self.nodes;
        while let Some((node, behind)) = rest.split_first() {
            let mut services: &[(u16, CanopenService)] = &NODE_SERVICES;
            while let Some(((base, service), others)) = services.split_first() {
                let clash = Clash::new(*base + *node as u16, *service, *node);
                if clash.concerns(axes) {
                    return Some(clash);
                }
                services = others;
            }
            rest = behind;
        }
        None
    }
}

impl Clash {
    const fn new(id: u16, service: CanopenService, node: u8) -> Self {
        Self {
            id,
            service,
            node,
            address: Address::from_can_id(id),
            function: FunctionCode::from_can_id(id),
        }
    }

    const fn concerns(&self, axes: &[AxisConfig]) -> bool {
        let Some(drive) = self.address.drive() else {
            return true;
        };
        let mut rest = axes;
        while let Some((axis, behind)) = rest.split_first() {
            if axis.drive.get() == drive.get() {
                return true;
            }
            rest = behind;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::config::test_axis;

    fn axes<const N: usize>(drives: [i32; N]) -> [AxisConfig; N] {
        drives.map(test_axis)
    }

    const QUIET: Canopen = Canopen {
        nodes: &[],
        uses_nmt: false,
        uses_sync: false,
    };

    #[test]
    fn nmt_zeroes_every_drive() {
        let canopen = Canopen {
            uses_nmt: true,
            ..QUIET
        };
        let clash = canopen.clash(&axes([60])).unwrap();
        assert_eq!((clash.id, clash.address), (0x000, Address::Broadcast));
        assert_eq!(clash.function, FunctionCode::SetOrigin);
    }

    #[test]
    fn sync_zeroes_drive_4_only() {
        let canopen = Canopen {
            uses_sync: true,
            ..QUIET
        };
        let clash = canopen.clash(&axes([1, 4])).unwrap();
        assert_eq!((clash.id, clash.function), (0x080, FunctionCode::SetOrigin));
        assert_eq!(canopen.clash(&axes([1, 2, 3, 5])), None);
    }

    /// D9: node 1 Go_Absolute, node 3 Go_Relative, node 10 Turn_ConstSpeed, of drive base / 32 + n / 32.
    #[test]
    fn pdos_move_motors() {
        for (node, function) in [
            (1, FunctionCode::GoAbsolutePosPtp),
            (3, FunctionCode::GoRelativePosPtp),
            (10, FunctionCode::TurnConstSpeed),
        ] {
            let nodes: &'static [u8] = std::boxed::Box::leak(std::boxed::Box::new([node]));
            let canopen = Canopen { nodes, ..QUIET };
            let clash = canopen.clash(&axes([12])).unwrap();
            assert_eq!(
                (clash.id, clash.service),
                (0x180 + u16::from(node), CanopenService::Pdo)
            );
            assert_eq!(clash.function, function);
            assert_eq!(canopen.clash(&axes([1, 2, 3, 5])), None);
            assert_eq!(canopen.invalid_node(), None);
        }
    }

    #[test]
    fn node_ids_end_at_127() {
        let canopen = Canopen {
            nodes: &[127, 128],
            ..QUIET
        };
        assert_eq!(canopen.invalid_node(), Some(128));
    }
}
