// Made by `make page` from editors/page, 0920a6324c7f97358c4eedd2242126eb97091680fcc84516e2f9f05da29d5670. All of it is porelang's.
var T=Math.PI/180,y={iso:[-45,Math.atan(Math.SQRT1_2)/T],front:[-90,0],back:[90,0],left:[180,0],right:[0,0],top:[-90,90],bottom:[-90,-90]},R=Math.tan(11*T),Z=1.06,N=(n,t)=>n[0]*t[0]+n[1]*t[1]+n[2]*t[2],tt=(n,t)=>[n[1]*t[2]-n[2]*t[1],n[2]*t[0]-n[0]*t[2],n[0]*t[1]-n[1]*t[0]],L=(n,t,e)=>[n[0]+e*t[0],n[1]+e*t[1],n[2]+e*t[2]],S=class{constructor(){[this.azimuth,this.elevation]=y.iso,this.target=[0,0,0],this.height=100,this.perspective=!0,this.fitted=!0}axes(){let t=this.azimuth*T,e=this.elevation*T,i=[Math.cos(t)*Math.cos(e),Math.sin(t)*Math.cos(e),Math.sin(e)],o=[-Math.sin(t),Math.cos(t),0];return{out:i,right:o,up:tt(i,o)}}turn(t,e){this.fitted=!1,this.azimuth=(this.azimuth+t)%360,this.elevation=Math.min(90,Math.max(-90,this.elevation+e))}move(t,e,i){this.fitted=!1;let{right:o,up:s}=this.axes(),a=this.height/i;this.target=L(L(this.target,o,-t*a),s,e*a)}closer(t){this.fitted=!1,this.height=Math.min(1e7,Math.max(1e-4,this.height/t))}fit(t,e,i){this.fitted=!0;let{out:o,right:s,up:a}=this.axes();this.target=t.map((h,d)=>(h+e[d])/2);let r=0,l=0;for(let h=0;h<8;h++){let d=t.map((f,p)=>(h>>p&1?e[p]:f)-this.target[p]),c=Z*Math.max(Math.abs(N(d,s))/i,Math.abs(N(d,a)));l=Math.max(l,c),r=Math.max(r,c/R+N(d,o))}this.height=this.perspective?2*R*r:2*l}uniforms(t){let{out:e,right:i,up:o}=this.axes(),s=this.perspective?this.height/2/R:2*t;return{eye:L(this.target,e,s),camera:[...i,...o,-e[0],-e[1],-e[2]],zoom:this.perspective?R:this.height/2,perspective:this.perspective?1:0}}};var v=n=>String(Number(Number(n).toPrecision(6)));function g(n,t={},...e){let i=Object.assign(document.createElement(n),t);return i.append(...e),i}var D=n=>n.split(`
`).map(t=>g("div",{className:/^ *\d* \|/.test(t)?"code":"words",textContent:t||" "}));function et(n){let t=10**Math.floor(Math.log10(n/250));return t*[5,2,1].find(e=>e*t<=n/250)}var P=/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;function $(n,t){let e=`param-${n.name}`,i=g("div",{className:"name"},g("label",{textContent:n.name,htmlFor:e})),o=g("div",{className:"param"},i);n.doc&&o.append(g("div",{className:"doc",id:`${e}-doc`,textContent:n.doc}));let s;if(n.choices.length)s=g("select",{},...n.choices.map(a=>new Option(String(a)))),o.put=a=>{s.value=String(a)},s.onchange=()=>t(n.name,n.choices[s.selectedIndex]);else{let[a,r,l]=[n.low,n.high,n.step].map(p=>p===null?null:p/n.scale);s=g("input",{type:"range"});let h=g("input",{type:"text",className:"number",autocomplete:"off",spellcheck:!1});h.setAttribute("aria-label",`${n.name}${n.unit?` in ${n.unit}`:""}`),Object.assign(s,{min:a,max:r,step:l??et(r-a)});let d=null;o.put=p=>{typeof p=="number"&&(s.value=p/n.scale,(h.value===d||h.getRootNode().activeElement!==h)&&(h.value=v(p/n.scale)),d=null)};let c=p=>{h.value=v(p),t(n.name,Math.min(Math.max(p*n.scale,n.low),n.high))},f=p=>{P.test(h.value.trim())&&(s.value=Number(h.value)),s.value=Number(s.value)+p*Number(s.step),c(Number(s.value))};s.oninput=()=>c(Number(s.value)),h.onchange=()=>{d=h.value;let p=d.trim(),m=P.test(p)?Number(p)*n.scale:NaN;m>=n.low&&m<=n.high&&(s.value=m/n.scale),t(n.name,Number.isFinite(m)?m:p)},h.onkeydown=p=>{p.key==="Enter"&&(p.preventDefault(),h.onchange());let m={ArrowUp:1,ArrowDown:-1}[p.key];!m||p.altKey||p.ctrlKey||p.metaKey||(p.preventDefault(),f(m))},s.title="Double click: its default",s.ondblclick=()=>{s.value=n.default/n.scale,c(n.default/n.scale)},i.append(g("div",{className:"box"},h,n.unit))}return s.id=e,n.doc&&s.setAttribute("aria-describedby",`${e}-doc`),o.append(s),o.put(n.value),o}function I(n,t,e,i){return n.map((o,s)=>{let a=g("input",{type:"checkbox",id:`output-${s}`,checked:t.includes(o)});a.onchange=()=>{let l=n.filter(h=>h===o?a.checked:t.includes(h));l.length?i(l):a.checked=!0};let r=g("span",{className:"swatch"});return e.has(o)&&(r.style.background=`rgb(${e.get(o).map(l=>Math.round(255*l)).join(" ")})`),g("label",{htmlFor:a.id},a,r,o)})}function j(n,t){if(n.hidden=!t,!t)return;let[e,i,o]=t.ends,s=g("canvas",{width:1,height:256}),a=s.getContext("2d"),r=c=>{let f=8*(c<i?.5*(c-e)/(i-e):.5+.5*(c-i)/(o-i)),p=Math.min(7,Math.max(0,Math.floor(f)));return t.colours[p].map((m,u)=>Math.round(255*(m+(f-p)*(t.colours[p+1][u]-m))))};for(let c=0;c<256;c++)a.fillStyle=`rgb(${r(o+(e-o)*c/255).join(" ")})`,a.fillRect(0,c,1,1);let h=[...new Set([e,...t.numbers,o])].filter(c=>c===e||c===o||Math.min(c-e,o-c)>.07*(o-e)).map(c=>{let f=g("span",{className:"tick",textContent:v(c.toPrecision(4))});return f.style.top=`${100*(o-c)/(o-e)}%`,f}),d=`${t.shown}${t.unit&&t.unit!==t.shown?` (${t.unit.replace(t.shown,"").trim()||t.unit})`:""}`;n.setAttribute("aria-label",`Colours of ${d}: from ${v(e)} to ${v(o)}`),n.replaceChildren(g("div",{className:"what",textContent:d}),g("div",{className:"scale"},s,...h))}function z(n,t={}){let{canvas:e,camera:i}=n,o=new Map;e.addEventListener("contextmenu",s=>s.preventDefault()),e.addEventListener("pointerdown",s=>{e.setPointerCapture(s.pointerId),o.set(s.pointerId,{x:s.clientX,y:s.clientY,moves:s.button!==0||s.shiftKey,cuts:s.altKey})}),e.addEventListener("pointermove",s=>{let a=o.get(s.pointerId);if(!a)return;let r=s.clientX-a.x,l=s.clientY-a.y;if(o.size===2){let[h]=[...o].filter(([f])=>f!==s.pointerId).map(([,f])=>f),d=Math.hypot(a.x-h.x,a.y-h.y),c=Math.hypot(s.clientX-h.x,s.clientY-h.y);d>0&&c>0&&i.closer(c/d),i.move(r/2,l/2,e.clientHeight)}else a.cuts?n.slide(r,l):a.moves?i.move(r,l,e.clientHeight):i.turn(-.4*r,.4*l);a.x=s.clientX,a.y=s.clientY,n.moved()});for(let s of["pointerup","pointercancel"])e.addEventListener(s,a=>o.delete(a.pointerId));e.addEventListener("wheel",s=>{s.preventDefault(),i.closer(Math.exp(-s.deltaY*(s.deltaMode===1?.04:.0015))),n.moved()},{passive:!1}),e.addEventListener("keydown",s=>{if(s.ctrlKey||s.metaKey)return;let a=s.shiftKey?1:5,r=s.altKey?{ArrowLeft:()=>n.step(-1),ArrowDown:()=>n.step(-1),ArrowRight:()=>n.step(1),ArrowUp:()=>n.step(1)}:{ArrowLeft:()=>i.turn(-a,0),ArrowRight:()=>i.turn(a,0),ArrowUp:()=>i.turn(0,a),ArrowDown:()=>i.turn(0,-a),"+":()=>i.closer(1.15),"=":()=>i.closer(1.15),"-":()=>i.closer(1/1.15),f:()=>n.fit(),o:()=>n.project(),...t};s.altKey||Object.keys(y).forEach((h,d)=>{r[d+1]=()=>n.stand(h)});let l=r[s.key]??r[s.key.toLowerCase()];l&&(s.preventDefault(),s.stopPropagation(),l(),n.moved())})}var st=`#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;var A=class{constructor(t,e,i){this.canvas=t,this.camera=e,this.told=i,this.scene=null,this.section={axis:-1,offset:0,keeps:1},this.coarse=4,this.perPixel=0,this.drawn=0,this.seen=null,this.first=null,this.refines=!0,this.start(),this.losses=0,t.addEventListener("webglcontextlost",o=>{o.preventDefault(),this.losses+=1,this.scene=null}),t.addEventListener("webglcontextrestored",()=>{if(this.start(),this.losses>3)return this.ready?.("This browser's graphics give up on the part: it takes them too long. `pore render` draws it.");this.wanted&&this.take(this.wanted,this.ready)})}start(){let t=this.canvas.getContext("webgl2",{antialias:!1,preserveDrawingBuffer:!0,alpha:!0,premultipliedAlpha:!0,depth:!0});if(!t)throw new Error("This browser has no WebGL 2 here, with which the part is drawn. `pore render` draws without it.");this.gl=t,this.parallel=t.getExtension("KHR_parallel_shader_compile"),this.programs=new Map,this.textures=[]}end(){clearTimeout(this.still),this.scene=this.wanted=null,this.wish=null,this.gl.getExtension("WEBGL_lose_context")?.loseContext()}take(t,e){let i=this.gl;if(i.isContextLost()){this.wanted=t,this.ready=e;return}let o=[...t.bodies,...t.plane?[t.plane]:[]],s=o.map(r=>this.compiled(r.text));this.wanted=t,this.ready=e;let a=()=>{if(!(this.wanted!==t||i.isContextLost())){if(this.parallel&&s.some(r=>!i.getProgramParameter(r.program,this.parallel.COMPLETION_STATUS_KHR)))return setTimeout(a,20);for(let r of s){if(i.getProgramParameter(r.program,i.LINK_STATUS))continue;let l=r.shaders.map(h=>i.getShaderInfoLog(h)).concat(i.getProgramInfoLog(r.program)).filter(Boolean).join(`
`);return e(`This browser's graphics driver refuses the shader of the part:
${l}`)}for(let[r,l]of this.programs)s.includes(l)||(i.deleteProgram(l.program),this.programs.delete(r));o.some(r=>!this.scene||![...this.scene.bodies,this.scene.plane].some(l=>l?.text===r.text))&&(this.coarse=8*(1+this.losses)),this.scene=t,this.load(o),e(""),this.moved()}};a()}compiled(t){if(this.programs.has(t))return this.programs.get(t);performance.mark("compiled");let e=this.gl,i=e.createProgram(),o=[[e.VERTEX_SHADER,st],[e.FRAGMENT_SHADER,t]].map(([a,r])=>{let l=e.createShader(a);return e.shaderSource(l,r),e.compileShader(l),e.attachShader(i,l),l});e.linkProgram(i);let s={program:i,shaders:o,places:new Map};return this.programs.set(t,s),s}load(t){let e=this.gl;for(let o of this.textures)e.deleteTexture(o);this.textures=[];let i=o=>{let s=e.createTexture();e.activeTexture(e.TEXTURE0),e.bindTexture(o,s);for(let a of[e.TEXTURE_WRAP_S,e.TEXTURE_WRAP_T])e.texParameteri(o,a,e.CLAMP_TO_EDGE);for(let a of[e.TEXTURE_MIN_FILTER,e.TEXTURE_MAG_FILTER])e.texParameteri(o,a,e.NEAREST);return this.textures.push(s),s};e.pixelStorei(e.UNPACK_ALIGNMENT,4);for(let o of t)o.units=[],o.cells&&(o.units.push([e.TEXTURE_3D,i(e.TEXTURE_3D),"cells"]),e.texImage3D(e.TEXTURE_3D,0,e.R32F,...o.counts,0,e.RED,e.FLOAT,o.cells)),o.data.forEach((s,a)=>{o.units.push([e.TEXTURE_2D,i(e.TEXTURE_2D),`data${a}`]);let r=Math.ceil(s.length/2048),l=new Uint32Array(r*2048);l.set(s),e.texImage2D(e.TEXTURE_2D,0,e.R32UI,2048,r,0,e.RED_INTEGER,e.UNSIGNED_INT,l)})}moved(){this.wish=(this.wish??0)+1,clearTimeout(this.still),!this.asked&&(this.asked=!0,requestAnimationFrame(()=>{if(this.asked=!1,!this.scene)return;this.quick();let t=this.wish;this.still=setTimeout(()=>this.full(t),150)}))}size(t){let e=Math.min(window.devicePixelRatio||1,2)/t;return[Math.max(1,Math.round(this.canvas.clientWidth*e)),Math.max(1,Math.round(this.canvas.clientHeight*e))]}quick(){let t=this.size(this.coarse);[this.canvas.width,this.canvas.height]=t;let e=performance.now();this.strip(t,0,t[1],1),this.wait(0);let i=performance.now()-e;this.perPixel=i/(t[0]*t[1]),this.told(`${t[0]} x ${t[1]}, ${i.toFixed(1)} ms`),this.seen!==this.scene&&(this.seen=this.scene,this.first?.()),i>40&&this.coarse<8?this.coarse=Math.min(8,this.coarse*Math.sqrt(i/40)):i<40/3&&(this.coarse=Math.max(1,this.coarse/1.3))}wait(t){this.gl.readPixels(0,t,1,1,this.gl.RGBA,this.gl.UNSIGNED_BYTE,new Uint8Array(4))}full(t,e=1){let i=this.gl,o=this.size(1),s=o.map(m=>m*e),a=Math.max(1,Math.floor(30/Math.max(this.perPixel,1e-9)/s[0])),r=performance.now(),l=i.createFramebuffer(),h=i.createRenderbuffer(),d=i.createRenderbuffer();i.bindFramebuffer(i.FRAMEBUFFER,l);for(let[m,u,b]of[[h,i.RGBA8,i.COLOR_ATTACHMENT0],[d,i.DEPTH_COMPONENT24,i.DEPTH_ATTACHMENT]])i.bindRenderbuffer(i.RENDERBUFFER,m),i.renderbufferStorage(i.RENDERBUFFER,u,...s),i.framebufferRenderbuffer(i.FRAMEBUFFER,b,i.RENDERBUFFER,m);i.bindFramebuffer(i.FRAMEBUFFER,null);let c=()=>{i.deleteFramebuffer(l),i.deleteRenderbuffer(h),i.deleteRenderbuffer(d)},f=s[1],p=()=>{if(this.wish!==t||!this.scene)return c();let m=f;if(f=Math.max(0,f-a),i.bindFramebuffer(i.FRAMEBUFFER,l),this.strip(s,f,m,e),this.wait(f),i.bindFramebuffer(i.FRAMEBUFFER,null),f>0)return setTimeout(p,0);[this.canvas.width,this.canvas.height]=o,i.bindFramebuffer(i.READ_FRAMEBUFFER,l),i.blitFramebuffer(0,0,...s,0,0,...o,i.COLOR_BUFFER_BIT,e>1?i.LINEAR:i.NEAREST),i.bindFramebuffer(i.READ_FRAMEBUFFER,null),c();let u=performance.now()-r;this.told(`${o[0]} x ${o[1]}${e>1?`, ${e*e} samples`:""}, ${u.toFixed(0)} ms`),!(e>1)&&(this.drawn+=1,this.canvas.dataset.drawn=this.drawn,u<400&&this.refines&&this.full(t,2))};p()}strip(t,e,i,o){let s=this.gl,a=this.scene,r=this.camera.uniforms(Math.hypot(...a.hi.map((c,f)=>c-a.lo[f]))),l=Math.max(...[...r.eye,...a.lo,...a.hi].map(Math.abs)),h=Math.hypot(...a.lo.map((c,f)=>Math.max(Math.abs(c-r.eye[f]),Math.abs(a.hi[f]-r.eye[f]))));s.viewport(0,0,...t),s.enable(s.SCISSOR_TEST),s.scissor(0,e,t[0],i-e),s.clearColor(0,0,0,0),s.clearDepth(1),s.clear(s.COLOR_BUFFER_BIT|s.DEPTH_BUFFER_BIT),s.enable(s.DEPTH_TEST),s.depthFunc(s.LEQUAL),s.disable(s.BLEND);let d=2**-23*l;for(let c of a.bodies)this.body(c,r,t,o,h,d);a.plane&&this.section.axis>=0&&(s.enable(s.BLEND),s.blendFunc(s.ONE,s.ONE_MINUS_SRC_ALPHA),this.plane(a,r,t,h,d)),s.disable(s.SCISSOR_TEST)}body(t,e,i,o,s,a){let r=[...t.lo],l=[...t.hi],h=[0,0,0],d=[0,0,0],{axis:c,offset:f,keeps:p}=this.section;if(c>=0){if(p>0?f>=l[c]:f<=r[c])return;p>0&&f>r[c]&&(r[c]=f,h[c]=1),p<0&&f<l[c]&&(l[c]=f,d[c]=1)}let m=Math.hypot(...t.hi.map((w,E)=>w-t.lo[E])),u=t.lo.map((w,E)=>(w+t.hi[E])/2),b=e.camera.slice(6),x=e.perspective?Math.max(1e-9,u.reduce((w,E,U)=>w+(E-e.eye[U])*b[U],0)):1,k=2*e.zoom*x/i[1],O=Math.hypot(...e.eye.map((w,E)=>w-u[E]))+m,C=Math.max(.2*k,1e-6*O,4*a);this.draw(t,e,i,{want:[1,"i",0],samples:[1,"i",o],side:[1,"f",1],layer:[1,"f",0],rounding:[1,"f",a],nearest:[1,"f",C],finest:[1,"f",Math.max(.01*k,1e-7*O,a)],jump:[1,"f",Math.max(.5*k,C)],reach:[1,"f",.1*m],grain:[1,"f",Math.max(.5*k,1e-5*O,32*a)],corner:[2,"f",[0,0]],farthest:[1,"f",s],box_lo:[3,"f",r],box_hi:[3,"f",l],cells_lo:[3,"f",t.lo],cells_hi:[3,"f",t.hi],cut_lo:[3,"f",h],cut_hi:[3,"f",d],counts:[3,"i",t.counts],material:[3,"f",t.colour],section:[3,"f",t.section]})}plane(t,e,i,o,s){let{axis:a,offset:r}=this.section;this.draw(t.plane,e,i,{box_lo:[3,"f",t.lo],box_hi:[3,"f",t.hi],axis:[1,"i",a],offset:[1,"f",r],farthest:[1,"f",o],nearer:[1,"f",Math.max(2e-6*o,8*s)],every:[1,"f",t.scale.every],clear:[1,"f",.45]})}draw(t,e,i,o){let s=this.gl,{program:a,places:r}=this.programs.get(t.text),l=c=>(r.has(c)||r.set(c,s.getUniformLocation(a,c)),r.get(c));s.useProgram(a),t.units.forEach(([c,f,p],m)=>{s.activeTexture(s.TEXTURE0+m),s.bindTexture(c,f),s.uniform1i(l(p),m)}),t.numbers.length&&s.uniform1fv(l("u"),t.numbers);let h=this.scene.scale;h&&(s.uniform3fv(l("scale_colours"),h.colours.flat()),s.uniform3fv(l("scale_ends"),h.ends));let d={zoom:[1,"f",e.zoom],perspective:[1,"f",e.perspective],size:[2,"f",i],eye:[3,"f",e.eye]};for(let[c,[f,p,m]]of Object.entries({...d,...o}))f===1?s[`uniform1${p}`](l(c),m):s[`uniform${f}${p}v`](l(c),m);s.uniformMatrix3fv(l("camera"),!1,e.camera),s.drawArrays(s.TRIANGLES,0,3)}};var F=["x","y","z"];function B(n,t,e){let i=10**Math.floor(Math.log10((e-t)/500));return Number((Math.round(n/i)*i).toPrecision(6))}var q={cross(n){let{section:t,state:e,state:{scene:i}}=this;!this.painter||!i||(n>=0&&n!==t.axis&&(t.offset=B((i.lo[n]+i.hi[n])/2,i.lo[n],i.hi[n]),t.keeps=this.camera.axes().out[n]>0?-1:1),t.axis=n,e.beyond=!1,this.ask.cut(t),this.across(),this.show(),this.moved())},across(){let{element:n,section:{axis:t,offset:e},state:{scene:i,plane:o,beyond:s}}=this;if(F.concat("none").forEach(l=>n(`across-${l}`).setAttribute("aria-pressed",String(l===(F[t]??"none")))),n("section-more").hidden=t<0,n("plane").setAttribute("aria-pressed",String(o)),t<0||!i)return;let a=i.lo[t],r=i.hi[t];Object.assign(n("offset"),{min:a,max:r}),n("offset").value=e,this.root.activeElement!==n("offset-number")&&(n("offset-number").value=v(e)),n("offset-beyond").hidden=!s&&e>=a&&e<=r,n("offset-beyond").textContent=`The part is between ${Number(a.toPrecision(4))} and ${Number(r.toPrecision(4))} mm.`},cutAt(n,t=!1){let{section:e,state:i,state:{scene:o}}=this,{axis:s}=e;if(s<0||!o)return;let a=o.lo[s],r=o.hi[s],l=Number.isFinite(n)?t?n:B(n,a,r):e.offset;e.offset=Math.min(Math.max(l,a),r),i.beyond=t&&l!==e.offset,this.element("offset-number").value=v(e.offset),this.ask.cut(e),this.across(),this.moved()},slide(n,t){let{camera:e,section:i}=this,{axis:o}=i;if(o<0)return;let{right:s,up:a}=e.axes(),r=Math.max(.05,s[o]**2+a[o]**2),h=(this.slid?.to===i.offset?this.slid.exact:i.offset)+(n*s[o]-t*a[o])/r*e.height/this.canvas.clientHeight;this.cutAt(h),this.slid={to:i.offset,exact:h}},step(n){let{section:{axis:t,offset:e},state:{scene:i}}=this;t>=0&&this.cutAt(e+n*(i.hi[t]-i.lo[t])/100)},cutSo({axis:n,offset:t,keeps:e}){Object.assign(this.section,n<0?{axis:n}:{axis:n,offset:t,keeps:e}),this.across(),this.moved()}};var H=n=>n&&`The picture is as before: ${n}.`,M=class{constructor(t,e,{stats:i=!1,refines:o=!0,keys:s={}}={}){this.root=t,this.ask=e,this.element=a=>t.getElementById(a),this.canvas=this.element("view"),this.camera=new S,this.told={},this.doings=new Map,this.state={program:null,settings:{},outputs:[],paint:"",plane:!1,scene:null,fitted:""},this.waiting=new Map;try{this.painter=new A(this.canvas,this.camera,a=>{this.element("stats").hidden=!i,this.element("stats").textContent=a}),this.painter.refines=o,this.painter.first=()=>this.pictured()}catch(a){this.painter=null,this.wrong("scene",a.message)}this.section=this.painter?.section??{axis:-1,offset:0,keeps:1},this.aspect=1,this.resized=new ResizeObserver(()=>this.reshaped()),this.resized.observe(this.canvas),z(this,s),this.buttons()}buttons(){let{element:t}=this;t("said-shut").onclick=()=>{t("said").hidden=!0},Object.keys(y).forEach((e,i)=>{let o=g("button",{textContent:e,title:String(i+1)});o.onclick=()=>this.stand(e),t("views").append(o)}),t("fit").onclick=()=>this.fit(),t("projection").onclick=()=>this.project();for(let[e,i]of[[-1,"none"],...F.entries()]){let o=g("button",{textContent:i,id:`across-${i}`});o.onclick=()=>this.cross(e),t("axes").append(o)}t("offset").oninput=()=>this.cutAt(Number(t("offset").value)),t("offset-number").onchange=()=>this.cutAt(parseFloat(t("offset-number").value),!0),t("said-again").onclick=()=>Object.values(this.told).find(e=>e.again).again(),t("flip").onclick=()=>{this.section.keeps*=-1,this.ask.cut(this.section),this.moved()},t("plane").onclick=()=>{this.state.plane=!this.state.plane,this.across(),this.show()},t("paint").onchange=()=>{this.state.paint=t("paint").value.trim(),this.show()},t("presets").onchange=()=>{t("presets").value&&this.ask.preset(t("presets").value)},t("defaults").onclick=()=>this.ask.preset("")}wrong(t,e,i="",o=null){let{element:s}=this;e?this.told[t]={text:e,label:i,again:o}:delete this.told[t];let{line:a,file:r,...l}=this.told,h=[a,r,...Object.values(l)].filter(Boolean),d=h.find(c=>c.again);s("said-text").replaceChildren(...D(h.map(c=>c.text).join(`

`))),s("said").hidden=!h.length,s("said-again").hidden=!d,s("said-again").textContent=d?.label??""}doing(t,e,i){let{element:o,doings:s}=this;e?s.set(t,{what:e,share:i}):s.delete(t);let[a,r]=[...s].find(([l])=>l!=="measure")??[];o("doing").hidden=!r,r&&(o("doing-what").textContent=r.what,o("doing-share").hidden=r.share===void 0,o("doing-share").value=r.share??0,o("stop").hidden=a!=="scene"&&a!=="export",o("stop").onclick=()=>this.ask.cancel(a))}heard(t){let{say:e,of:i}=t;e==="scene"?this.take(t):e==="program"?this.programmed(t):e==="doing"?this.doing(i,t.what,t.share):e==="done"?this.doing(i,""):e==="refused"?this.wrong(i,t.text&&[t.text,H(t.still)].filter(Boolean).join(`

`)):e==="settings"?this.put(t.settings):e==="stopped"&&this.stopped(t)}stopped({still:t,wish:e}){let{outputs:i,paint:o,plane:s}=this.state;this.wished(e),this.wrong("scene",`Cancelled. ${H(t)||"Nothing is drawn yet."}`,"Try again",()=>{this.wrong("scene",""),this.wished({outputs:i,paint:o,plane:s}),this.show()})}moved(){this.painter?.moved(),this.ask.moved?.()}reshaped(){let{camera:t,canvas:e}=this,i=e.clientWidth/e.clientHeight;!i||!Number.isFinite(i)||(t.fitted?this.fit():t.height*=Math.min(1,this.aspect)/Math.min(1,i),this.aspect=i,this.moved())}take(t){let{state:e}=this;this.painter&&(this.doing("shader","compiling the shader"),this.painter.take(t,i=>{if(this.wrong("scene",i),this.doing("shader",i?"":"drawing"),i)return;e.scene=t;let o=t.bodies.map(s=>s.name).join(" ");this.canvas.dataset.outputs=o,(e.fitted?e.fitted!==o:this.camera.fitted)&&this.fit(),e.fitted=o,this.across(),this.listed(),this.moved()}))}pictured(){this.doing("shader",""),j(this.element("legend"),this.state.scene.scale)}fit(){let{scene:t}=this.state,{canvas:e}=this;t&&(this.camera.fit(t.lo,t.hi,e.clientWidth/e.clientHeight),this.moved())}stand(t){[this.camera.azimuth,this.camera.elevation]=y[t],this.fit()}project(){this.camera.perspective=!this.camera.perspective,this.element("projection").setAttribute("aria-pressed",String(!this.camera.perspective)),this.camera.fitted&&this.fit(),this.moved()}set(t,e){this.state.settings[t]=e,this.waiting.size||requestAnimationFrame(()=>{this.ask.set(Object.fromEntries(this.waiting)),this.waiting.clear()}),this.waiting.set(t,e)}put(t){Object.assign(this.state.settings,t);let e=this.element("params").children;this.state.program?.params.forEach(({name:i},o)=>{i in t&&e[o].put(t[i])})}wished(t){Object.assign(this.state,t),this.element("paint").value=t.paint,this.across(),this.listed()}show(){let{outputs:t,paint:e,plane:i}=this.state;this.ask.show({outputs:t,paint:e,plane:i&&this.section.axis>=0})}listed(){let{element:t,state:e}=this,i=e.program?.bodies??[];if(t("outputs").hidden=i.length<2,i.length<2)return;let o=e.scene?.bodies??[],s=o.map(r=>r.name),a=new Map(o.map(r=>[r.name,r.colour]));t("outputs").replaceChildren(g("h2",{textContent:"Outputs"}),...I(i,s,a,r=>{e.outputs=r,this.show()}))}programmed(t){let{element:e,state:i}=this,o=this.root.activeElement?.id;i.program=t,!i.scene&&t.wish&&this.wished(t.wish),e("file").textContent=t.file,this.wrong("text",t.wrong.join(`

`)),i.settings=Object.fromEntries(t.params.filter(s=>s.value!==s.default).map(s=>[s.name,s.value])),e("params-all").hidden=!t.params.length,e("params").replaceChildren(...t.params.map(s=>$(s,(a,r)=>this.set(a,r)))),e("presets").hidden=!t.presets.length,e("presets").replaceChildren(new Option("preset ...",""),...t.presets.map(s=>new Option(s))),e("fields").replaceChildren(...t.fields.map(s=>g("option",{value:s}))),this.listed(),o&&e(o)?.focus({preventScroll:!0})}close(){this.resized.disconnect(),this.painter?.end()}};Object.assign(M.prototype,q);function X(n){let t=new DataView(n).getUint32(0,!0),e=JSON.parse(new TextDecoder().decode(new Uint8Array(n,4,t))),i=4+t,o=(s,a)=>(i+=4*a,new s(n,i-4*a,a));for(let s of K(e))s.numbers=new Float32Array(s.numbers),s.counts&&(s.cells=o(Float32Array,s.counts[0]*s.counts[1]*s.counts[2])),s.data=s.words.map(a=>o(Uint32Array,a));return{say:"scene",...e}}var K=n=>[...n.bodies,...n.plane?[n.plane]:[]],_=class{constructor(){this.known=[]}forget(){this.known=[]}into(t){K(t).forEach((e,i)=>{e.text??=this.known[t.plane===e?"plane":i]}),this.known=t.bodies.map(e=>e.text),this.known.plane=t.plane?.text}};var W=`<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>porelang</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="page.css">
</head>
<body>
<section id="source" aria-label="Program" hidden>
  <div class="bar">
    <strong id="state" role="status"></strong>
    <span class="room"></span>
    <button id="style" title="Alt-Shift-F">Format</button>
    <button id="save" title="Ctrl-S">Save</button>
    <button id="shut" aria-label="Hide the program">\xD7</button>
  </div>
  <div id="conflict" role="alert" hidden>
    Another program has changed the file.
    <button id="theirs">Take what is on disk</button> <button id="ours">Save this over it</button>
  </div>
  <div id="editor"></div>
</section>
<main>
  <canvas id="view" tabindex="0" role="application" aria-label="The part. Arrow keys turn it, with Alt they move the section; plus and minus zoom, F fits it, digits 1 to 7 choose a view, O changes the projection."></canvas>
  <div id="legend" role="img" hidden></div>
  <div id="doing" role="status" hidden><span id="doing-what"></span> <progress id="doing-share" max="1"></progress> <button id="stop">Cancel</button></div>
  <div id="stats" hidden></div>
  <div id="said" role="alert" hidden><button id="said-shut" aria-label="Close this message">\xD7</button><div id="said-text"></div><button id="said-again" hidden></button></div>
</main>
<aside aria-label="Settings">
  <header><h1 id="file">porelang</h1><button id="open" aria-pressed="false" title="E">Program</button></header>
  <section id="outputs" aria-label="Outputs" hidden></section>
  <section aria-label="Params" id="params-all" hidden>
    <div class="row"><select id="presets" aria-label="Preset" hidden></select><button id="defaults">Defaults</button></div>
    <div id="params"></div>
  </section>
  <section aria-label="Section">
    <h2>Section</h2>
    <div class="row" id="axes" role="group" aria-label="Section across"></div>
    <div id="section-more" hidden>
      <input type="range" id="offset" aria-label="Offset of the section" step="any">
      <div class="row"><input id="offset-number" class="number" aria-label="Offset of the section in mm" inputmode="decimal" autocomplete="off"> <span class="quiet">mm</span>
        <button id="flip">Flip</button> <button id="plane" aria-pressed="false">Field on it</button></div>
      <div id="offset-beyond" class="quiet" role="status" hidden></div>
    </div>
  </section>
  <section aria-label="Colour">
    <h2><label for="paint">Colour by</label></h2>
    <input id="paint" list="fields" placeholder="nothing, or a field: z, stress, ..." autocomplete="off" spellcheck="false">
    <datalist id="fields"></datalist>
  </section>
  <section aria-label="View">
    <h2>View</h2>
    <div class="row" id="views"></div>
    <div class="row"><button id="fit" title="F">Fit</button> <button id="projection" title="O" aria-pressed="false">Parallel</button></div>
  </section>
  <section aria-label="Measures" id="measures" aria-live="polite" hidden>
    <h2 id="measures-head">Measures</h2>
    <dl id="rows"></dl>
    <ul id="checks"></ul>
  </section>
  <section aria-label="Export">
    <h2>Export</h2>
    <div class="row">
      <select id="ending" aria-label="Format"></select>
      <label class="quiet" for="voxel">voxel</label> <input id="voxel" value="auto" size="6" spellcheck="false">
    </div>
    <div class="row">
      <button id="export">Mesh</button> <button id="picture">Picture</button>
    </div>
    <div id="made"></div>
  </section>
  <section id="doubts" aria-label="Warnings" hidden></section>
  <footer>Drag turns, Shift-drag or the right button moves, the wheel zooms, Alt-drag moves the section.</footer>
</aside>
<script type="module" src="page.js"><\/script>
</body>
</html>
`;var G=`:root, :host {
  color-scheme: light dark;
  --ground: #ffffff; --panel: #f6f6f4; --text: #22231f; --quiet: #63655e; --line: #d5d5ce; --accent: #9a4d27;
  --wrong: #9c1c1c; --wrong-ground: #fff4f2; --well: #2f6b3a;
}
@media (prefers-color-scheme: dark) {
  :root, :host {
    --ground: #1b1c1a; --panel: #242522; --text: #e9e8e2; --quiet: #a8a79f; --line: #44453f; --accent: #e39a70;
    --wrong: #ffb4a8; --wrong-ground: #3a1f1b; --well: #9ad0a0;
  }
}
* { box-sizing: border-box; }
html, body { height: 100%; margin: 0; }
body { display: flex; background: var(--ground); color: var(--text); font: 14px/1.45 system-ui, sans-serif; }
main { flex: 1 1 40%; position: relative; min-width: 0; min-height: 0; overflow: hidden; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { outline: 2px solid var(--accent); outline-offset: -2px; }
#source { flex: 1 1 34%; min-width: 260px; max-width: 60%; display: flex; flex-direction: column; border-right: 1px solid var(--line); resize: horizontal; overflow: hidden; }
#editor { flex: 1; min-height: 0; overflow: hidden; }
#editor > * { height: 100%; }
.bar { display: flex; gap: 6px; align-items: center; padding: 6px 10px; background: var(--panel); border-bottom: 1px solid var(--line); }
.bar strong { font-weight: 600; overflow-wrap: anywhere; }
.room { flex: 1; }
#conflict { padding: 8px 10px; color: var(--wrong); background: var(--wrong-ground); }
aside { flex: none; width: 304px; overflow-y: auto; background: var(--panel); border-left: 1px solid var(--line); padding: 14px 16px; }
aside header { display: flex; gap: 8px; align-items: baseline; justify-content: space-between; margin-bottom: 10px; }
h1 { font-size: 16px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 12px; font-weight: 600; color: var(--quiet); margin: 16px 0 6px; }
.param { margin: 0 0 14px; }
.param .name { display: flex; justify-content: space-between; gap: 8px; align-items: baseline; }
.param label { font-weight: 600; overflow-wrap: anywhere; }
.param .doc { color: var(--quiet); font-size: 12px; margin: 1px 0 3px; }
input[type=range] { width: 100%; accent-color: var(--accent); margin: 2px 0; padding: 0; }
.box { display: flex; align-items: baseline; gap: 4px; color: var(--quiet); }
.number { width: 84px; text-align: right; }
#paint { width: 100%; }
input, select, button { font: inherit; color: inherit; background: var(--ground); border: 1px solid var(--line); border-radius: 4px; padding: 2px 6px; }
.param select { width: 100%; }
button { padding: 3px 9px; cursor: pointer; }
button:hover { border-color: var(--accent); }
button:disabled { opacity: .5; cursor: default; }
button[aria-pressed=true] { border-color: var(--accent); color: var(--accent); }
:focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
.row { display: flex; flex-wrap: wrap; gap: 6px; margin-bottom: 6px; align-items: baseline; }
.quiet { color: var(--quiet); }
#outputs label { display: flex; gap: 8px; align-items: center; padding: 2px 0; }
.swatch { width: 12px; height: 12px; border-radius: 3px; border: 1px solid var(--line); }
#said { position: absolute; left: 16px; right: 16px; bottom: 16px; max-height: 60%; overflow: auto; padding: 12px 16px;
  color: var(--wrong); background: var(--wrong-ground); border: 1px solid currentColor; border-radius: 6px; }
.code { white-space: pre; }
.words { white-space: pre-wrap; overflow-wrap: anywhere; }
#said-text { overflow-x: auto; font: 13px/1.45 ui-monospace, monospace; }
#said-shut { float: right; border: 0; background: none; padding: 0 4px; font-size: 18px; line-height: 1; }
#said-again { margin-top: 10px; }
#doing, #stats { position: absolute; right: 12px; top: 12px; padding: 3px 10px; border-radius: 12px; font-size: 12px; color: var(--quiet);
  background: var(--panel); border: 1px solid var(--line); }
#doing { display: flex; gap: 8px; align-items: center; }
#doing progress { width: 80px; accent-color: var(--accent); }
#doing button { padding: 0 8px; }
#stats { right: auto; left: 12px; font-variant-numeric: tabular-nums; }
#legend { position: absolute; left: 14px; top: 44px; font-size: 12px; pointer-events: none; font-variant-numeric: tabular-nums; }
#legend .what { margin-bottom: 6px; }
#legend .what, #legend .tick { padding: 0 3px; background: color-mix(in srgb, var(--ground) 70%, transparent); border-radius: 3px; }
#legend .scale { position: relative; height: 180px; }
#legend canvas { position: static; width: 14px; height: 180px; border: 1px solid var(--line); }
#legend .tick { position: absolute; left: 20px; transform: translateY(-50%); white-space: nowrap; }
dl { display: grid; grid-template-columns: minmax(40px, 1fr) auto; gap: 2px 10px; margin: 0; }
dt { color: var(--quiet); overflow: hidden; text-overflow: ellipsis; white-space: nowrap; }
dd { margin: 0; text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
dd.wide { grid-column: 1 / -1; white-space: normal; }
dd.of { grid-column: 1 / -1; text-align: left; white-space: normal; color: var(--quiet); font-size: 12px; padding-left: 10px; }
#checks { list-style: none; padding: 0; margin: 8px 0 0; }
#checks li.holds { color: var(--well); }
#checks li.fails { color: var(--wrong); }
#checks .quiet { font-size: 12px; padding-left: 16px; }
#made a { color: var(--accent); overflow-wrap: anywhere; }
#doubts { font: 12px/1.4 ui-monospace, monospace; color: var(--quiet); border-top: 1px solid var(--line); padding-top: 12px; margin-top: 16px; overflow-x: auto; }
footer { color: var(--quiet); font-size: 12px; margin-top: 20px; }
[hidden] { display: none !important; }
@media (max-width: 900px) { #source { max-width: 45%; min-width: 200px; } aside { width: 240px; } }
@media (max-width: 640px) { body { flex-direction: column; } #source { max-width: none; min-height: 30%; border-right: 0; border-bottom: 1px solid var(--line); } main { min-height: 40%; } aside { width: auto; max-height: 40%; border-left: 0; border-top: 1px solid var(--line); } }
`;var V=`:host { display: block; container-type: inline-size; width: 100%; }
.frame { display: flex; height: var(--height, 460px); background: var(--ground); color: var(--text); font: 14px/1.45 system-ui, sans-serif;
  border: 1px solid var(--line); border-radius: 4px; overflow: hidden; }
#panel { width: 264px; }
#panel[inert] { opacity: 0.5; }
#still { position: absolute; inset: 0; width: 100%; height: 100%; object-fit: contain; }
@container (max-width: 520px) {
  .frame { flex-direction: column; height: auto; }
  main { flex: none; height: var(--height, 460px); }
  #panel { width: auto; border-left: 0; border-top: 1px solid var(--line); }
}
`;var J="xyz",at="The kernel that this belongs to has been restarted: run the cell again. The picture is the last one.",Nt=()=>{let n=new Set,t=new _,e={},i=!1;return{initialize({model:o}){let s=()=>{i=!0;for(let r of n)r.lost(i)},a=(r,l)=>{if(i){i=!1;for(let h of n)h.lost(i)}if(r.say==="scene"){let{buffer:h,byteOffset:d,byteLength:c}=l[0];r=X(h.slice(d,d+c)),t.into(r)}["program","scene"].includes(r.say)&&(e[r.say]=r),r.say==="refused"&&(e[`refused ${r.of}`]=r),r.say==="scene"&&delete e["refused scene"];for(let h of n)h.heard(Y(r))};return o.on("msg:custom",a),o.on("comm_live_update",s),o.send({do:"begin"}),()=>{o.off("msg:custom",a),o.off("comm_live_update",s)}},render({model:o,el:s}){let a=document.createElement("div"),r=a.attachShadow({mode:"open"});a.dataset.lmSuppressShortcuts="true",s.append(a);let l=[lt(a,r),ct(r,o)],h=u=>{for(let[b,x]of Object.entries(u))o.set(b,x);o.save_changes()},d=new M(r,{set:u=>h({settings:{...o.get("settings"),...u}}),show:h,preset:u=>o.send({do:"preset",name:u}),cancel:()=>o.send({do:"cancel"}),cut:u=>h({cut:Q(u)})}),{state:c,element:f}={state:d.state,element:d.element},p={settings:u=>d.put(u),outputs:u=>{c.outputs=u},paint:u=>{c.paint=u,r.activeElement!==f("paint")&&(f("paint").value=u)},height:u=>a.style.setProperty("--height",`${u}px`),plane:u=>{c.plane=u,u&&c.scene&&d.section.axis<0&&d.cross(1),d.across()},cut:u=>{u!==Q(d.section)&&d.cutSo(rt(u))}};for(let[u,b]of Object.entries(p)){let x=()=>b(o.get(u));o.on(`change:${u}`,x),l.push(()=>o.off(`change:${u}`,x))}p.height(o.get("height"));let m={lost(u){f("panel").inert=u,d.wrong("kernel",u?at:"")},heard(u){if(u.say==="program"&&(f("panel").hidden=!1),d.heard(u),u.say==="program")for(let[b,x]of Object.entries(p))x(o.get(b));u.say==="scene"&&(d.wrong("scene",""),c.plane&&p.plane(!0))}};n.add(m);for(let u of[e.program,e.scene])u&&m.heard(Y(u));for(let u of Object.values(e))u.say==="refused"&&m.heard(u);return i&&m.lost(i),()=>{n.delete(m),d.close();for(let u of l)u()}}}};function Y(n){return n.say!=="scene"?n:{...n,bodies:n.bodies.map(t=>({...t})),plane:n.plane&&{...n.plane}}}function Q({axis:n,offset:t,keeps:e}){return n<0?"":`${J[n]}${e>0?"<":">"}${Number(t.toPrecision(6))}`}function rt(n){return{axis:J.indexOf(n[0]??"-"),offset:Number(n.slice(2)),keeps:n[1]==="<"?1:-1}}function lt(n,t){let e=[G,V].map(d=>{let c=new CSSStyleSheet;return c.replaceSync(d),c});t.adoptedStyleSheets=e;let i=new DOMParser().parseFromString(W,"text/html"),o=i.querySelector("main"),s=i.querySelector("aside");for(let d of s.querySelectorAll("#open, #measures, #doubts, [aria-label=Export]"))d.remove();Object.assign(s,{id:"panel",hidden:!0});let a=document.createElement("div");a.className="frame",a.append(o,s),t.append(a);let r=matchMedia("(prefers-color-scheme: dark)"),l=()=>{let{jpThemeLight:d,vscodeThemeKind:c}=document.body.dataset,f=d?d==="false":c?/dark$|contrast$/.test(c):r.matches;n.style.colorScheme=f?"dark":"light";for(let p of e[0].cssRules)p.media&&[...p.cssRules].some(m=>m.style?.getPropertyValue("--ground"))&&(p.media.mediaText=f?"all":"not all")};l();let h=new MutationObserver(l);return h.observe(document.body,{attributes:!0,attributeFilter:["data-jp-theme-light","data-vscode-theme-kind"]}),r.addEventListener("change",l),()=>{h.disconnect(),r.removeEventListener("change",l)}}function ct(n,t){let e=document.createElement("img");e.id="still",e.alt="The part",n.querySelector("main").prepend(e);let i="",o=()=>{let a=t.get("still");URL.revokeObjectURL(i),i=a?.byteLength?URL.createObjectURL(new Blob([a],{type:"image/png"})):"",e.hidden=!i,i&&(e.src=i)};o(),t.on("change:still",o);let s=new MutationObserver(()=>{e.hidden=!0});return s.observe(n.getElementById("view"),{attributes:!0,attributeFilter:["data-outputs"]}),()=>{t.off("change:still",o),s.disconnect(),URL.revokeObjectURL(i)}}export{Nt as default};
