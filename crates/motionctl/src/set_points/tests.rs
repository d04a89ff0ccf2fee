//! Motions at any speed, judged by finite differences of the rows.

use proptest::prelude::*;

use super::*;

const CYCLE_US: u32 = 1_000;
/// Acceleration is a mean over so many cycles.
const WINDOW: usize = 20;
const CYCLES: f64 = 3_000.0;
const RADIUS: f64 = 8_000.0;

/// A circle that begins and ends slowly: its angle is a minimum-jerk curve.
struct Circle {
    turns: f64,
}

impl Circle {
    fn angle(&self, cycles: f64) -> f64 {
        let share = (cycles / CYCLES).clamp(0.0, 1.0);
        let eased = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        self.turns * core::f64::consts::TAU * eased
    }
}

impl MotionInTime for Circle {
    fn axes(&self) -> usize {
        2
    }

    fn duration_cycles(&self) -> f64 {
        CYCLES
    }

    fn at(&self, cycles: f64, counts: &mut [f64]) {
        let angle = self.angle(cycles);
        counts[0] = RADIUS * (1.0 - angle.cos());
        counts[1] = RADIUS * angle.sin();
    }
}

/// Largest velocity, and largest mean acceleration over the window, of rows.
fn needs(rows: &[[i32; 2]], axis: usize) -> (f64, f64) {
    let at = |place: usize| f64::from(rows[place][axis]);
    let velocity = (1..rows.len()).map(|place| (at(place) - at(place - 1)).abs());
    let acceleration = (2 * WINDOW..rows.len()).map(|place| {
        (at(place) - 2.0 * at(place - WINDOW) + at(place - 2 * WINDOW)).abs()
            / (WINDOW * WINDOW) as f64
    });
    (
        velocity.fold(0.0, f64::max),
        acceleration.fold(0.0, f64::max),
    )
}

fn exact_rows(circle: &Circle) -> Vec<[f64; 2]> {
    let mut counts = [0.0; 2];
    (0..=CYCLES as usize)
        .map(|cycle| {
            circle.at(cycle as f64, &mut counts);
            counts
        })
        .collect()
}

fn rows_at_100_percent(circle: &Circle) -> Vec<[i32; 2]> {
    let rows = exact_rows(circle).into_iter();
    rows.map(|row| row.map(|counts| counts.round() as i32))
        .collect()
}

/// The circle with limits that are so many times what it needs at 100 %.
fn source(
    turns: f64,
    velocity: f64,
    acceleration: f64,
) -> (TimedMotion<Circle>, Vec<AxisHeadroom>) {
    let rows = rows_at_100_percent(&Circle { turns });
    let headroom = |axis| {
        let (needed_velocity, needed_acceleration) = needs(&rows, axis);
        AxisHeadroom {
            velocity: velocity * needed_velocity,
            acceleration: acceleration * needed_acceleration,
            needed_velocity,
            needed_acceleration,
        }
    };
    let axes: Vec<AxisHeadroom> = (0..2).map(headroom).collect();
    (
        TimedMotion::new(Circle { turns }, axes.clone(), CYCLE_US),
        axes,
    )
}

/// How far each point is from the polygon of the exact rows, the larger of both axes. Rounding alone makes up to 0.61 of a count
/// of it, so no two set-points of the same place differ by more than one. Points go along it, and never back.
fn check_path(ideal: &[[f64; 2]], points: &[[i32; 2]]) {
    let mut near = 0_usize;
    for point in points {
        let [x, y] = point.map(f64::from);
        let mut nearest = (f64::INFINITY, 0.0, near);
        // A step at 200 % is two rows, and a standstill none.
        for place in near.saturating_sub(5)..(near + 45).min(ideal.len() - 1) {
            let [[x0, y0], [x1, y1]] = [ideal[place], ideal[place + 1]];
            let (dx, dy) = (x1 - x0, y1 - y0);
            let length = dx * dx + dy * dy;
            let along = (x - x0) * dx + (y - y0) * dy;
            let share = if length == 0.0 {
                0.0
            } else {
                (along / length).clamp(0.0, 1.0)
            };
            let off = [x - x0 - share * dx, y - y0 - share * dy];
            let distance = off[0].hypot(off[1]);
            if distance <= nearest.0 {
                nearest = (distance, off[0].abs().max(off[1].abs()), place);
            }
        }
        near = nearest.2;
        assert!(
            nearest.1 <= 0.65,
            "{point:?} is {} counts off the path",
            nearest.1
        );
    }
}

fn play(source: &mut dyn SetPointSource, orders: &[(usize, Order)]) -> (Vec<[i32; 2]>, Step) {
    // Rest before and after, as far as the windows look.
    let mut rows = vec![[0; 2]; 2 * WINDOW];
    let mut row = [0; 2];
    let mut orders = orders.iter().peekable();
    let mut next_at = 0;
    for cycle in 0..200_000 {
        while cycle >= next_at
            && let Some((wait, order)) = orders.next()
        {
            source.order(*order);
            next_at = cycle + wait;
        }
        if orders.peek().is_none() && cycle == next_at {
            // In the end everything goes on.
            source.order(Order::Resume);
            if source.speed().asked_percent < 20 {
                source.order(Order::Override(100));
            }
        }
        let step = source.next(&mut row);
        rows.push(row);
        if step != Step::Goes {
            rows.extend([row; 2 * WINDOW]);
            return (rows, step);
        }
    }
    panic!("it never ended");
}

fn check(rows: &[[i32; 2]], axes: &[AxisHeadroom], turns: f64) {
    for (axis, headroom) in axes.iter().enumerate() {
        let (velocity, acceleration) = needs(rows, axis);
        // Rounding to whole counts: one count in a step, two in a second difference.
        let most = (
            headroom.velocity + 1.0,
            headroom.acceleration + 2.0 / (WINDOW * WINDOW) as f64,
        );
        assert!(
            velocity <= most.0,
            "axis {axis}: velocity {velocity} of {}",
            most.0
        );
        assert!(
            acceleration <= most.1,
            "axis {axis}: acceleration {acceleration} of {}",
            most.1
        );
    }
    let ideal = exact_rows(&Circle { turns });
    check_path(&ideal, rows);
}

#[test]
fn overrides_of_0_50_and_200_percent_stay_on_a_circle() {
    let (mut source, axes) = source(1.0, 2.0, 4.2);
    let orders = [
        (500, Order::Override(50)),
        (800, Order::Override(0)),
        (500, Order::Override(200)),
        (200, Order::Pause),
        (400, Order::Resume),
    ];
    let (rows, step) = play(&mut source, &orders);
    assert_eq!((step, rows[rows.len() - 1]), (Step::Completed, [0, 0]));
    check(&rows, &axes, 1.0);
    assert_eq!(source.next_notice(), None);
}

#[test]
fn an_override_beyond_the_limits_is_held_and_said() {
    let (mut source, axes) = source(1.0, 1.5, 4.2);
    let (rows, _) = play(&mut source, &[(0, Order::Override(200))]);
    check(&rows, &axes, 1.0);
    let notice = source.next_notice().expect("it is said");
    assert!(
        notice.contains("speed 200 %") && notice.contains("held to 150 %"),
        "{notice}"
    );
    assert!((source.highest_rate() - 1.5).abs() < 0.02);
}

#[test]
fn a_stop_ends_on_the_path_and_the_row_stays() {
    let (mut source, axes) = source(1.0, 1.1, 1.3);
    let (rows, step) = play(&mut source, &[(1_400, Order::Resume), (5_000, Order::Stop)]);
    assert_eq!(step, Step::Stopped);
    check(&rows, &axes, 1.0);
    let mut row = [0; 2];
    assert_eq!(source.next(&mut row), Step::Stopped);
    source.order(Order::Resume);
    source.next(&mut row);
    assert_eq!(row, rows[rows.len() - 1]);
    assert_ne!(row, [0, 0]);
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        Just(Order::Pause),
        Just(Order::Resume),
        (0..=200_u16).prop_map(Order::Override),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Any orders at any times, with limits that leave much or nothing: on the path, and within the limits.
    #[test]
    fn random_orders_keep_path_and_limits(
        orders in proptest::collection::vec((0..700_usize, order()), 1..14),
        turns in prop_oneof![Just(0.25), Just(1.0), Just(2.0)],
        velocity in 1.0..2.5_f64,
        acceleration in 1.02..6.0_f64,
    ) {
        let (mut source, axes) = source(turns, velocity, acceleration);
        let (rows, step) = play(&mut source, &orders);
        prop_assert_eq!(step, Step::Completed);
        check(&rows, &axes, turns);
    }
}
