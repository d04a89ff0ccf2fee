use firmware_tests::{
    motion::Drives,
    names::Names,
    orders::{self, Handlers},
    profile::Profile,
    rig,
};
fn main() {
    let drives = Drives {
        count: 4,
        response_us: 500,
    };
    let image = rig::image("link");
    let path = std::path::PathBuf::from(std::env::var("FIRMWARE_IMAGES").unwrap())
        .join(rig::chip().name)
        .join("link");
    let names = Names::read(&path).unwrap();
    let (mut rig, mut host) = orders::enabled(image, drives);
    for moving in [false, true] {
        if moving {
            orders::set_moving(&mut rig, &mut host, 6_000);
        }
        rig.board_mut().soc_mut().profile = Some(Profile::default());
        let h = Handlers::count(&mut rig, 1_000, |rig| host.run_ms(rig, 1));
        let profile = rig.board_mut().soc_mut().profile.take().unwrap();
        println!("moving {moving} {h:?}");
        let image = rig.board().image();
        let mut rows: Vec<(f64, String)> = Vec::new();
        for (f, contexts) in profile.functions(image, &names) {
            let j = format!("{contexts:?}");
            let n: u64 = contexts
                .iter()
                .filter(|(c, _)| c.to_string() != "thread" && !format!("{c:?}").contains("thread"))
                .map(|(_, n)| *n)
                .sum();
            let _ = j;
            rows.push((n as f64 / 1000.0, f.name.clone()));
        }
        rows.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (n, name) in rows.iter().take(45) {
            println!("{n:8.1} {name}");
        }
    }
}
