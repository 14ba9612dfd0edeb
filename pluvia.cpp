#include <cstdio>
#include "raytrace/generate.h"
#include "validate/real_factors.h"
int main(int c,char**v){ auto p=pluvia::read_preset(v[1]); if(c>4){p.view_elevations_deg={atoi(v[4])};} auto s=pluvia::generate_database(p,v[2],[](const std::string&w,double x){static double l=0; if(x>l+.1){l=x;fprintf(stderr,"%s %.2f\n",w.c_str(),x);}});
 printf("%d %d %.1f\n",s.traced,s.found,s.cpu_s);
 auto m=pluvia::read_manifest(v[2]); auto f=pluvia::compare_factors(v[2],m,pluvia::read_real_factors(v[3]));
 for(int o=-1;o<10;o++){printf("osc %d: ",o);for(int e:{10,50,90})printf(" %d: %.4f",e,pluvia::factor_rms(f,o,e));printf("\n");}
 for(auto&r:f.residuals) if(r.real.oscillation==0||r.real.oscillation==2||r.real.oscillation==4||r.real.oscillation==3) printf("osc%d v%d h%d %.3f\n",r.real.oscillation,r.real.light.elevation_deg,r.real.light.azimuth_deg,r.log10_ratio);
}
