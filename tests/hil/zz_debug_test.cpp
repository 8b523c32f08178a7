#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstdio>
#include <sstream>
#include "tests/hil/drives_model.hpp"
using namespace sortie; using namespace sortie::hil::test;
template <class Kind> void replay() {
  typename Kind::Config config;
  config.group.rearm_ns = std::atoi(getenv("REARM"))*rt::kNanosecondsPerMillisecond;
  DrivesModel<Kind> m{DrivesWorld<Kind>(false, config), {}, config.group.rearm_ns>0};
  m.world.ask(false); m.pass(3000); m.world.ask(true); m.pass(600);
  std::istringstream way(getenv("WAY")); int d; int dwell=std::atoi(getenv("DWELL"));
  int last=-1;
  auto watch=[&](int ms){ for(int i=0;i<ms && m.found.empty();++i){ m.pass(1);
    auto&g=m.world.runtime().group(); int key=(int)g.state()*100+(int)g.reason();
    int k2=key*1000+(int)m.world.node(0).state()*10+(int)m.world.node(1).state()+m.world.driven(0)*7000000+m.world.driven(1)*70000000+m.world.drive_speaks_*1000000000;
    if(k2!=last){last=k2; printf("%5ld ms group %d %-28s node0 %d node1 %d driven %d %d\n",(long)(m.world.now()/1000000),(int)g.state(),drivers::to_string(g.reason()),(int)m.world.node(0).state(),(int)m.world.node(1).state(),(int)m.world.driven(0),(int)m.world.driven(1));} } };
  while(way>>d){ printf("--- deed %d at %ld\n",d,(long)(m.world.now()/1000000)); 
    if(d==0){m.world.ask(false);watch(12);m.world.ask(true);} else m.act((Deed)d); watch(dwell);}
  printf("FOUND %s\n",m.found.c_str());
}
TEST_CASE("zz debug","[.]"){ if(getenv("OD")) replay<OdriveKind>(); else replay<CanopenKind>(); }
