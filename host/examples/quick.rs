//! quick
use shisen::cave::*; use shisen::render::*; use shisen::scene::builtin::*; use shisen::scene::*;
fn main(){
 let a:Vec<String>=std::env::args().collect();
 let which: PaperScene = a[1].parse().unwrap();
 let mesh = if a.len()>2 { shisen::import::load(std::path::Path::new(&a[2])).unwrap() } else { shisen::quadruped::quadruped() };
 let mut scene = paper_scene(which, mesh).unwrap();
 if a.len()>3 { for o in &mut scene.objects { o.smooth=false; } }
 let t=std::time::Instant::now();
 let baked = shisen::bake::Baked::<8>::new(&scene).unwrap();
 println!("bake {:?} {} B stack {}", t.elapsed(), baked.as_bytes().len(), baked.scene().stack_entries());
 let cave_ = Cave::built_in(BuiltInCave::ThreeWall,[256,256]).unwrap();
 let v=Viewer::default();
 let mut o=Options::default();
 for th in [1,2] { for tile in [32,13] { o.threads=th; o.tile=tile;
 let f=cave(&baked.scene(),&cave_,&[(Eye::Left,v.eye(Eye::Left)),(Eye::Right,v.eye(Eye::Right))],&o,&|_,_|{}).unwrap();
 println!("{:x} {:?} {}",f.hash(),f.statistics,f.seconds);
 if th==2 && tile==13 { for p in &f.pictures { p.picture.write_png(std::path::Path::new(&format!("/tmp/q-{}-{}.png",cave_.walls[p.wall].name,p.eye)),&[]).unwrap(); }
  let l:Vec<_>=f.pictures.iter().filter(|p|p.eye==Eye::Left).map(|p|(&cave_.walls[p.wall],&p.picture)).collect();
  shisen::net::unfold(&l).unwrap().write_png(std::path::Path::new("/tmp/q-cave.png"),&[]).unwrap(); }
 }}
}
