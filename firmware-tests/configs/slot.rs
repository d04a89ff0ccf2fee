// Made by `motionctl keyframes`, to be included by a configuration of the firmware.
//
// examples/programs/slot.ngc: 7 lines, 4 moves, 1.936 s
// ┌───────────────────────────────────────────────────────────────────────────┐
// │ axis   drive   travel from the start, mm   largest step        peak speed │
// │                                            counts in a cycle   mm/s       │
// ╞═══════════════════════════════════════════════════════════════════════════╡
// │ X      1       -8.000 to 38.000            328                 100.1      │
// │ Y      2       -0.017 to 16.017            253                 77.2       │
// └───────────────────────────────────────────────────────────────────────────┘
// in cycles of 1000 us the set-points differ from those of `motionctl run` by at most 1 count

/// The built-in motion: 55 keyframes that are passed at speed.
pub(crate) const MOTION: trajectory::curve::KeyframeMotion<'static, 2> =
    match trajectory::curve::KeyframeMotion::passing(&PASSED, &PASSED_COUNTS_PER_S) {
        Ok(motion) => motion,
        Err(_) => panic!("the keyframes are not what was written"),
    };

const fn passed(at_ms: u32, positions_counts: [i32; 2]) -> trajectory::curve::Keyframe<2> {
    trajectory::curve::Keyframe {
        at_ms,
        positions_counts,
    }
}

/// Drive and gear number of each axis: the positions are those of these.
pub(crate) const MOTION_DRIVES: [(i32, i32); 2] = [(1, 4096), (2, 4096)];

const PASSED: [trajectory::curve::Keyframe<2>; 55] = [
    passed(0, [0, 0]),
    passed(83, [3824, 0]),
    passed(105, [7651, 0]),
    passed(184, [30509, 0]),
    passed(249, [51808, 0]),
    passed(302, [68101, 0]),
    passed(332, [75234, 0]),
    passed(384, [84310, 0]),
    passed(425, [90861, -18]),
    passed(458, [96148, -52]),
    passed(501, [102980, 466]),
    passed(530, [107429, 1643]),
    passed(555, [111052, 3308]),
    passed(589, [115596, 6512]),
    passed(621, [119482, 10765]),
    passed(649, [122350, 15774]),
    passed(675, [124092, 21503]),
    passed(700, [124488, 27482]),
    passed(724, [123619, 33022]),
    passed(744, [122153, 37097]),
    passed(769, [119729, 41319]),
    passed(803, [115822, 45716]),
    passed(835, [111670, 48766]),
    passed(876, [105685, 51352]),
    passed(910, [100372, 52298]),
    passed(953, [93498, 52475]),
    passed(984, [88537, 52431]),
    passed(1004, [85342, 52429]),
    passed(1053, [76466, 52429]),
    passed(1083, [68990, 52429]),
    passed(1134, [53050, 52429]),
    passed(1157, [45514, 52429]),
    passed(1207, [30204, 52429]),
    passed(1236, [23278, 52429]),
    passed(1289, [13994, 52429]),
    passed(1331, [7283, 52448]),
    passed(1364, [1996, 52479]),
    passed(1406, [-4676, 51963]),
    passed(1438, [-9572, 50617]),
    passed(1459, [-12608, 49198]),
    passed(1493, [-17164, 46028]),
    passed(1526, [-21178, 41663]),
    passed(1549, [-23591, 37646]),
    passed(1576, [-25605, 31832]),
    passed(1598, [-26213, 26446]),
    passed(1620, [-25673, 20914]),
    passed(1643, [-23931, 15513]),
    passed(1668, [-21031, 10566]),
    passed(1702, [-16275, 5664]),
    passed(1736, [-11453, 2634]),
    passed(1773, [-6860, 913]),
    passed(1815, [-2994, 172]),
    passed(1854, [-894, 15]),
    passed(1897, [-76, 0]),
    passed(1936, [0, 0]),
];

const PASSED_COUNTS_PER_S: [[i32; 2]; 55] = [
    [0, 0],
    [138176, 0],
    [209343, 0],
    [327680, 0],
    [327616, 0],
    [268885, 0],
    [206943, 0],
    [159680, 0],
    [160022, -1589],
    [160178, 1433],
    [156548, 26949],
    [149561, 54835],
    [139794, 77797],
    [127862, 112225],
    [113619, 155762],
    [87849, 202340],
    [42817, 234382],
    [-11582, 239267],
    [-58764, 218532],
    [-85899, 188254],
    [-106092, 150488],
    [-122683, 110210],
    [-137366, 81413],
    [-152888, 43354],
    [-158710, 14134],
    [-160258, -1521],
    [-159771, -528],
    [-160182, 0],
    [-218089, 0],
    [-280130, 0],
    [-327680, 0],
    [-327233, 0],
    [-268886, 0],
    [-208890, 0],
    [-159680, 0],
    [-160040, 1640],
    [-160157, -1728],
    [-156547, -26948],
    [-148566, -57791],
    [-140195, -76904],
    [-128206, -111064],
    [-113620, -155762],
    [-93994, -193985],
    [-51412, -234365],
    [-2223, -251910],
    [51006, -247076],
    [98069, -219317],
    [130278, -175096],
    [144735, -114633],
    [135857, -65991],
    [110517, -29966],
    [72642, -8353],
    [35073, -1198],
    [6724, -20],
    [0, 0],
];
